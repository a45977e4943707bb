// The remap of evenstep for C# 6 and later: evenstep_remap.h declared once more, with nothing but the base library. Copy
// this file into a project (in Unity below Assets), and libevenstep_remap_c.so to where it is found (in Unity below
// Assets/Plugins, elsewhere a folder of LD_LIBRARY_PATH).
using System;
using System.Diagnostics;
using System.Runtime.InteropServices;

namespace Evenstep
{
    /// <summary>Why a call was refused.</summary>
    public enum RemapCode
    {
        /// <summary>It was not.</summary>
        Ok,
        /// <summary>A number outside its range or not finite.</summary>
        Invalid,
        /// <summary>A time before the previous one, or BeginStep and EndStep do not take turns.</summary>
        Order,
        /// <summary>This file and the library are of different versions.</summary>
        AbiSize,
        /// <summary>There is not enough memory.</summary>
        Memory,
        /// <summary>A fault of the library.</summary>
        Broken
    }

    /// <summary>How forces are played.</summary>
    public enum Emission : uint
    {
        /// <summary>The latest force that is due.</summary>
        Hold,
        /// <summary>The line between two forces, which needs one slot more latency.</summary>
        Linear
    }

    /// <summary>How a read ended.</summary>
    public enum ReadStatus : uint
    {
        /// <summary>Between two entries, or on one.</summary>
        Inside,
        /// <summary>Past the newest entry: its value, or the line through the last ones.</summary>
        Underrun,
        /// <summary>Older than the ring holds: its oldest value, wrong for this time.</summary>
        Overrun,
        /// <summary>No entry yet, or before the first force: zeros.</summary>
        Empty
    }

#pragma warning disable 0169, 0649 // the library fills in what is never assigned here

    /// <summary>How a remap is set up. Begin with <see cref="Defaults"/>.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RemapOptions
    {
        internal uint StructSize;
        /// <summary>Of a position and of a force, 1 to 8; default 3.</summary>
        public uint Components;
        /// <summary>A step reads the hand at its slot minus this, ns. May be negative. <c>evenstep size</c> computes it and
        /// the latency.</summary>
        public long LeadNs;
        /// <summary>A force is played so long after the time at which its step has read the hand, ns.</summary>
        public long LatencyNs;
        /// <summary>How forces are played; default linear.</summary>
        public Emission Emission;
        /// <summary>1: the latency follows what the steps need, by the Adapt fields; default 0.</summary>
        public uint Adapts;
        /// <summary>How fast the map follows a change of pace, 1e-3 to 1e3 Hz; default 2. Not used with a
        /// <see cref="StepClock"/>.</summary>
        public double BandwidthHz;
        /// <summary>Samples that the ring of the hand holds, 2 to 1048576; default 64.</summary>
        public uint SampleCapacity;
        /// <summary>Forces that the ring of forces holds, 2 to 1048576; default 64.</summary>
        public uint ForceCapacity;
        /// <summary>A read past the newest sample gets its value, or with a window above 0 the line through the samples of
        /// the last so many ns.</summary>
        public long SampleWindowNs;
        /// <summary>So far past the newest sample the line goes, ns.</summary>
        public long SampleFurthestNs;
        /// <summary>The same for forces, ns.</summary>
        public long ForceWindowNs;
        /// <summary>The same for forces, ns.</summary>
        public long ForceFurthestNs;
        /// <summary>With Adapts: the latency at the start, in place of LatencyNs, ns.</summary>
        public long AdaptStartNs;
        /// <summary>With Adapts: the latency is at least this, ns.</summary>
        public long AdaptLeastNs;
        /// <summary>With Adapts: the latency is at most this, ns.</summary>
        public long AdaptMostNs;
        /// <summary>With Adapts: the latency shrinks after so long without need, ns; default 10 s.</summary>
        public long AdaptWindowNs;
        /// <summary>With Adapts: kept above what was needed, ns; default 1 ms.</summary>
        public long AdaptMarginNs;
        /// <summary>With Adapts: by how many millionths the latency shrinks, 0 to 500000; default 5000.</summary>
        public long AdaptSlewPpm;

        /// <summary>The library's defaults; lead and latency are 0.</summary>
        public static RemapOptions Defaults()
        {
            Remap.CheckLibrary();
            var options = new RemapOptions();
            Remap.Check(Native.evenstep_remap_options_init(ref options, Sizes.Options));
            return options;
        }
    }

    /// <summary>The clock of a loop that knows its own simulation time, such as Unity's FixedUpdate.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct StepClock
    {
        internal uint StructSize;
        internal uint Reserved;
        /// <summary>So many steps simulate so many <see cref="Seconds"/>: 50 and 1. Each 1 to 1e9.</summary>
        public long Steps;
        /// <summary>See <see cref="Steps"/>.</summary>
        public long Seconds;
        /// <summary>By how much a step may move the slots after the loop has dropped simulated time, ns; 0: by all of
        /// it.</summary>
        public long DroppedJumpNs;

        /// <summary>The clock of steps of this size, rounded to a nanosecond: 0.02 s are 50 steps in 1 second.</summary>
        public static StepClock OfStep(double stepSeconds)
        {
            const long second = 1000000000;
            double ns = Math.Round(stepSeconds * second);
            if (!(ns >= 1 && ns <= second))
                throw new ArgumentOutOfRangeException("stepSeconds", stepSeconds, "expected 1e-9 to 1 s");
            long a = second, b = (long)ns; // their greatest common divisor
            while (b != 0)
            {
                long rest = a % b;
                a = b;
                b = rest;
            }
            return new StepClock { Steps = second / a, Seconds = (long)ns / a };
        }
    }

    /// <summary>What a step has read.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct StepRead
    {
        internal uint StructSize;
        /// <summary>How the read of the hand ended.</summary>
        public ReadStatus Status;
        /// <summary>The time at which the hand was read, ns; the begin of a step that has no slot.</summary>
        public long ReadNs;
        /// <summary>Time of the newest sample that was visible, ns; 0 if there was none.</summary>
        public long NewestNs;
        /// <summary>0 while the map has not seen a complete segment: the newest sample was read.</summary>
        public uint HasSlot;
        internal uint Reserved;
    }

    /// <summary>What has happened so far.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RemapCounts
    {
        internal uint StructSize;
        internal uint Reserved;
        /// <summary>Steps that have begun.</summary>
        public ulong Steps;
        /// <summary>Of these: without a slot yet.</summary>
        public ulong Acquiring;
        /// <summary>Forces that came too late for a tick that needs them: a larger latency is needed.</summary>
        public ulong LateForces;
        /// <summary>By how much the latest of them, ns.</summary>
        public long LatestForceNs;
        /// <summary>Reads of the hand between two samples.</summary>
        public ulong HandInside;
        /// <summary>Reads past the newest sample, answered with its value: a larger lead is needed.</summary>
        public ulong HandHeld;
        /// <summary>Reads past the newest sample, answered with the line through the last ones.</summary>
        public ulong HandExtrapolated;
        /// <summary>Reads of a time that the ring no longer holds: a larger SampleCapacity is needed.</summary>
        public ulong HandOverruns;
        /// <summary>Reads before the first sample.</summary>
        public ulong HandEmpty;
        /// <summary>Reads of forces between two of them.</summary>
        public ulong ForceInside;
        /// <summary>Reads past the last force, answered with its value: a larger latency is needed.</summary>
        public ulong ForceHeld;
        /// <summary>Reads past the last force, answered with the line through the last ones.</summary>
        public ulong ForceExtrapolated;
        /// <summary>Reads of a time that the ring no longer holds: a larger ForceCapacity is needed.</summary>
        public ulong ForceOverruns;
        /// <summary>Reads before the first force.</summary>
        public ulong ForceEmpty;
    }

#pragma warning restore 0169, 0649

    /// <summary>A call that the library has refused, in its own words. It has changed nothing.</summary>
    public sealed class RemapException : Exception
    {
        internal RemapException(RemapCode code, string message) : base(message) { Code = code; }

        /// <summary>Why it was refused.</summary>
        public RemapCode Code { get; }
    }

    /// <summary>Nanoseconds since the program began, from a clock that is never set back.</summary>
    public static class SteadyClock
    {
        private static readonly long Start = Stopwatch.GetTimestamp();

        /// <summary>The time now, ns. Any thread.</summary>
        public static long NowNs()
        {
            long ticks = Stopwatch.GetTimestamp() - Start;
            return ticks / Stopwatch.Frequency * 1000000000 + ticks % Stopwatch.Frequency * 1000000000 / Stopwatch.Frequency;
        }
    }

    /// <summary>Maps between the even time of a device and the uneven time of a simulation's steps. One device thread and
    /// one simulation thread at the same time, each with its own calls, which neither wait nor allocate unless they are
    /// refused (<see cref="RemapException"/>). Times are ns since a start that is the same for all calls; positions and
    /// forces have the units of the caller, and at least RemapOptions.Components numbers.</summary>
    public sealed class Remap : IDisposable
    {
        private static volatile bool libraryFits;
        private readonly RemapHandle handle;
        private readonly int components;

        /// <summary>A remap for a simulation that draws, and then makes its steps: <see cref="Segment"/> and
        /// <see cref="BeginStep"/>.</summary>
        public Remap(RemapOptions options)
        {
            CheckLibrary();
            IntPtr made;
            Check(Native.evenstep_remap_create(ref options, out made));
            handle = new RemapHandle(made);
            components = (int)options.Components;
        }

        /// <summary>A remap for a loop that knows its own simulation time, by the map clocked: <see cref="BeginStepAt"/>,
        /// and no segments.</summary>
        public Remap(RemapOptions options, StepClock clock)
        {
            CheckLibrary();
            IntPtr made;
            clock.StructSize = Sizes.Clock;
            Check(Native.evenstep_remap_create_clocked(ref options, ref clock, out made));
            handle = new RemapHandle(made);
            components = (int)options.Components;
        }

        /// <summary>Device thread: where the hand is. Times do not decrease.</summary>
        public void Sample(long nowNs, double[] position)
        {
            Fits(position, "position");
            Check(Native.evenstep_remap_sample(handle, nowNs, position));
        }

        /// <summary>Device thread: the force to play, written to <paramref name="force"/>.</summary>
        public ReadStatus Force(long nowNs, double[] force)
        {
            ReadStatus status;
            Fits(force, "force");
            Check(Native.evenstep_remap_force(handle, nowNs, force, out status));
            return status;
        }

        /// <summary>Simulation thread: a visualization and the steps after it begin. Times do not decrease.</summary>
        public void Segment(long beginNs)
        {
            Check(Native.evenstep_remap_segment(handle, beginNs));
        }

        /// <summary>Simulation thread: a step begins, and computes with <paramref name="position"/>, which is written. Takes
        /// turns with <see cref="EndStep"/>; times do not decrease.</summary>
        public StepRead BeginStep(long nowNs, double[] position)
        {
            var read = new StepRead { StructSize = Sizes.Read };
            Fits(position, "position");
            Check(Native.evenstep_remap_begin_step(handle, nowNs, position, ref read));
            return read;
        }

        /// <summary>The same with the step's own simulation time, ns from any origin, with what the loop has dropped so far
        /// added to it.</summary>
        public StepRead BeginStepAt(long nowNs, long simulatedNs, double[] position)
        {
            var read = new StepRead { StructSize = Sizes.Read };
            Fits(position, "position");
            Check(Native.evenstep_remap_begin_step_at(handle, nowNs, simulatedNs, position, ref read));
            return read;
        }

        /// <summary>Simulation thread: the step has ended with this force. Returns when it is played, ns.</summary>
        public long EndStep(long nowNs, double[] force)
        {
            long emissionNs;
            Fits(force, "force");
            Check(Native.evenstep_remap_end_step(handle, nowNs, force, out emissionNs));
            return emissionNs;
        }

        /// <summary>What has happened so far. Any thread.</summary>
        public RemapCounts Counts()
        {
            var counts = new RemapCounts { StructSize = Sizes.Counts };
            Check(Native.evenstep_remap_get_counts(handle, ref counts));
            return counts;
        }

        /// <summary>Gives the memory back as soon as no call is in the library; calls after that are refused.</summary>
        public void Dispose() { handle.Dispose(); }

        // What the library cannot see: it would write past the end.
        private void Fits(double[] values, string name)
        {
            if (values == null) throw new ArgumentNullException(name);
            if (values.Length < components)
                throw new ArgumentException("has " + values.Length + " numbers; the remap has " + components, name);
        }

        internal static void Check(int code)
        {
            if (code != (int)RemapCode.Ok)
                throw new RemapException((RemapCode)code, Marshal.PtrToStringAnsi(Native.evenstep_remap_last_error()));
        }

        // Once: is the library there, of this version, and does it know these structs? A handle for nobody else is asked.
        internal static void CheckLibrary()
        {
            if (libraryFits) return;
            uint abi;
            try
            {
                abi = Native.evenstep_remap_abi();
            }
            catch (DllNotFoundException missing)
            {
                throw new DllNotFoundException("lib" + Native.Library + ".so was not found: name its folder in "
                    + "LD_LIBRARY_PATH, or copy it below Assets/Plugins", missing);
            }
            if (abi != Native.Abi)
                throw new RemapException(RemapCode.AbiSize, Native.Library + " has interface " + abi + ", Evenstep.cs has "
                    + Native.Abi + ": take both from one version of evenstep");
            var options = new RemapOptions();
            var clock = new StepClock { StructSize = Sizes.Clock, Steps = 1, Seconds = 1 };
            var read = new StepRead { StructSize = Sizes.Read };
            var counts = new RemapCounts { StructSize = Sizes.Counts };
            IntPtr made;
            Check(Native.evenstep_remap_options_init(ref options, Sizes.Options));
            Check(Native.evenstep_remap_create_clocked(ref options, ref clock, out made));
            using (var nobodys = new RemapHandle(made))
            {
                Check(Native.evenstep_remap_begin_step_at(nobodys, 0, 0, new double[options.Components], ref read));
                Check(Native.evenstep_remap_get_counts(nobodys, ref counts));
            }
            libraryFits = true;
        }
    }

    // Destroys the remap once, and not while a call is in the library.
    internal sealed class RemapHandle : SafeHandle
    {
        internal RemapHandle(IntPtr made) : base(IntPtr.Zero, true) { SetHandle(made); }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        protected override bool ReleaseHandle()
        {
            Native.evenstep_remap_destroy(handle);
            return true;
        }
    }

    internal static class Sizes
    {
        internal static readonly uint Options = (uint)Marshal.SizeOf(typeof(RemapOptions));
        internal static readonly uint Clock = (uint)Marshal.SizeOf(typeof(StepClock));
        internal static readonly uint Read = (uint)Marshal.SizeOf(typeof(StepRead));
        internal static readonly uint Counts = (uint)Marshal.SizeOf(typeof(RemapCounts));
    }

    // Arrays of doubles and these structs are passed as they lie in memory, so nothing is copied or allocated.
    internal static class Native
    {
        internal const string Library = "evenstep_remap_c";
        internal const uint Abi = 1;
        private const CallingConvention C = CallingConvention.Cdecl;

        [DllImport(Library, CallingConvention = C)]
        internal static extern uint evenstep_remap_abi();
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_options_init(ref RemapOptions options, uint structSize);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_create(ref RemapOptions options, out IntPtr remap);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_create_clocked(ref RemapOptions options, ref StepClock clock,
            out IntPtr remap);
        [DllImport(Library, CallingConvention = C)]
        internal static extern void evenstep_remap_destroy(IntPtr remap);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_sample(RemapHandle remap, long nowNs, [In] double[] position);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_force(RemapHandle remap, long nowNs, [In, Out] double[] force,
            out ReadStatus status);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_segment(RemapHandle remap, long beginNs);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_begin_step(RemapHandle remap, long nowNs, [In, Out] double[] position,
            ref StepRead read);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_begin_step_at(RemapHandle remap, long nowNs, long simulatedNs,
            [In, Out] double[] position, ref StepRead read);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_end_step(RemapHandle remap, long nowNs, [In] double[] force,
            out long emissionNs);
        [DllImport(Library, CallingConvention = C)]
        internal static extern int evenstep_remap_get_counts(RemapHandle remap, ref RemapCounts counts);
        [DllImport(Library, CallingConvention = C)]
        internal static extern IntPtr evenstep_remap_last_error();
    }
}
