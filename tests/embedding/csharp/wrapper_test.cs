// wrapper_test.exe CASE : what examples/csharp/Evenstep.cs promises. Says what is wrong, and exits with 1.
using System;
using System.IO;
using System.Threading;
using Evenstep;

internal static class WrapperTest
{
    private static int failures;

    private static int Main(string[] arguments)
    {
        switch (arguments[0])
        {
            case "numbers": Numbers(new BinaryReader(new BufferedStream(Console.OpenStandardInput(), 1 << 16))); break;
            case "refusals": Refusals(); break;
            case "allocations": Allocations(); break;
            case "threads": Threads(); break;
            case "opens": RemapOptions.Defaults(); break;
            default: throw new ArgumentException("no case " + arguments[0]);
        }
        return failures == 0 ? 0 : 1;
    }

    private static void Expect(bool holds, string what)
    {
        if (holds) return;
        ++failures;
        if (failures <= 20) Console.WriteLine("wrong: " + what);
    }

    // --- the numbers of remap_calls.cpp, which come in by their names ------------------------------------------------

    private static RemapOptions ReadOptions(BinaryReader reader)
    {
        RemapOptions o = RemapOptions.Defaults();
        o.Components = reader.ReadUInt32();
        o.LeadNs = reader.ReadInt64();
        o.LatencyNs = reader.ReadInt64();
        o.Emission = (Emission)reader.ReadUInt32();
        o.Adapts = reader.ReadUInt32();
        o.BandwidthHz = reader.ReadDouble();
        o.SampleCapacity = reader.ReadUInt32();
        o.ForceCapacity = reader.ReadUInt32();
        o.SampleWindowNs = reader.ReadInt64();
        o.SampleFurthestNs = reader.ReadInt64();
        o.ForceWindowNs = reader.ReadInt64();
        o.ForceFurthestNs = reader.ReadInt64();
        o.AdaptStartNs = reader.ReadInt64();
        o.AdaptLeastNs = reader.ReadInt64();
        o.AdaptMostNs = reader.ReadInt64();
        o.AdaptWindowNs = reader.ReadInt64();
        o.AdaptMarginNs = reader.ReadInt64();
        o.AdaptSlewPpm = reader.ReadInt64();
        return o;
    }

    private static bool Same(BinaryReader reader, RemapCounts c)
    {
        bool same = reader.ReadUInt64() == c.Steps;
        same &= reader.ReadUInt64() == c.Acquiring;
        same &= reader.ReadUInt64() == c.LateForces;
        same &= reader.ReadInt64() == c.LatestForceNs;
        same &= reader.ReadUInt64() == c.HandInside;
        same &= reader.ReadUInt64() == c.HandHeld;
        same &= reader.ReadUInt64() == c.HandExtrapolated;
        same &= reader.ReadUInt64() == c.HandOverruns;
        same &= reader.ReadUInt64() == c.HandEmpty;
        same &= reader.ReadUInt64() == c.ForceInside;
        same &= reader.ReadUInt64() == c.ForceHeld;
        same &= reader.ReadUInt64() == c.ForceExtrapolated;
        same &= reader.ReadUInt64() == c.ForceOverruns;
        return reader.ReadUInt64() == c.ForceEmpty && same;
    }

    private static void ReadValue(BinaryReader reader, double[] value, uint components)
    {
        for (uint i = 0; i < components; ++i) value[i] = reader.ReadDouble();
    }

    private static bool SameValue(BinaryReader reader, double[] value, uint components)
    {
        bool same = true;
        for (uint i = 0; i < components; ++i)
            same &= BitConverter.DoubleToInt64Bits(reader.ReadDouble()) == BitConverter.DoubleToInt64Bits(value[i]);
        return same;
    }

    private static bool SameStep(BinaryReader reader, Remap remap, long atNs, double[] value, uint components, bool clocked)
    {
        long simulatedNs = reader.ReadInt64();
        StepRead read = clocked ? remap.BeginStepAt(atNs, simulatedNs, value) : remap.BeginStep(atNs, value);
        bool same = SameValue(reader, value, components);
        same &= reader.ReadUInt32() == (uint)read.Status;
        same &= reader.ReadInt64() == read.ReadNs;
        same &= reader.ReadInt64() == read.NewestNs;
        return reader.ReadUInt32() == read.HasSlot && same;
    }

    private static bool SameCall(BinaryReader reader, Remap remap, double[] value, uint components, bool clocked)
    {
        int what = reader.ReadInt32();
        long atNs = reader.ReadInt64();
        switch (what)
        {
            case 0:
                ReadValue(reader, value, components);
                remap.Sample(atNs, value);
                return true;
            case 1:
                ReadStatus status = remap.Force(atNs, value);
                bool same = SameValue(reader, value, components);
                return reader.ReadUInt32() == (uint)status && same;
            case 2:
                remap.Segment(atNs);
                return true;
            case 3:
                return SameStep(reader, remap, atNs, value, components, clocked);
            default:
                ReadValue(reader, value, components);
                long emissionNs = remap.EndStep(atNs, value);
                return reader.ReadInt64() == emissionNs;
        }
    }

    private static void Numbers(BinaryReader reader)
    {
        Expect(ReadOptions(reader).Equals(RemapOptions.Defaults()), "the defaults are others");
        int runs = reader.ReadInt32();
        long calls = 0;
        for (int run = 0; run < runs; ++run)
        {
            bool clocked = reader.ReadInt32() == 1;
            RemapOptions options = ReadOptions(reader);
            var clock = new StepClock();
            clock.Steps = reader.ReadInt64();
            clock.Seconds = reader.ReadInt64();
            clock.DroppedJumpNs = reader.ReadInt64();
            int count = reader.ReadInt32();
            var value = new double[options.Components];
            using (Remap remap = clocked ? new Remap(options, clock) : new Remap(options))
            {
                for (int i = 0; i < count; ++i, ++calls)
                    Expect(SameCall(reader, remap, value, options.Components, clocked), "run " + run + ", call " + i);
                Expect(Same(reader, remap.Counts()), "run " + run + ": the counts");
            }
        }
        Console.WriteLine(failures + " of " + calls + " calls differ");
    }

    // --- what is refused ---------------------------------------------------------------------------------------------

    private static void Refused<T>(Action call, string words) where T : Exception
    {
        try
        {
            call();
            Expect(false, "not refused: " + words);
        }
        catch (T error)
        {
            Expect(error.Message.Contains(words), "'" + error.Message + "' lacks '" + words + "'");
        }
    }

    private static void Refusals()
    {
        RemapOptions options = RemapOptions.Defaults();
        options.Components = 9;
        Refused<RemapException>(() => new Remap(options), "evenstep_remap_create: components is 9, not in 1 to 8");
        options.Components = 3;
        Refused<RemapException>(() => new Remap(options, new StepClock()), "steps is 0");
        Refused<RemapException>(() => new Remap(new RemapOptions()), "struct_size is 0");
        Refused<ArgumentOutOfRangeException>(() => StepClock.OfStep(0), "expected 1e-9 to 1 s");
        Refused<ArgumentOutOfRangeException>(() => StepClock.OfStep(double.NaN), "expected 1e-9 to 1 s");
        StepClock fifty = StepClock.OfStep(0.02f), ninety = StepClock.OfStep(1.0 / 90);
        Expect(fifty.Steps == 50 && fifty.Seconds == 1, "0.02 s are not 50 steps a second");
        Expect(ninety.Steps * 11111111 == ninety.Seconds * 1000000000, "1/90 s is not 11111111 ns");

        var value = new double[3];
        var remap = new Remap(options);
        remap.Sample(10, value);
        Refused<RemapException>(() => remap.Sample(9, value),
            "evenstep_remap_sample: now_ns is 9 ns, before the time of the last one, 10 ns");
        Refused<RemapException>(() => remap.Sample(11, new[] { 0, double.NaN, 0 }), "position[1] is not finite");
        Refused<RemapException>(() => remap.EndStep(11, value), "no step has begun");
        Refused<ArgumentException>(() => remap.Sample(11, new double[2]), "has 2 numbers; the remap has 3");
        Refused<ArgumentException>(() => remap.Force(11, new double[2]), "has 2 numbers");
        Refused<ArgumentException>(() => remap.BeginStep(11, new double[2]), "has 2 numbers");
        Refused<ArgumentException>(() => remap.BeginStepAt(11, 0, new double[2]), "has 2 numbers");
        Refused<ArgumentException>(() => remap.EndStep(11, new double[2]), "has 2 numbers");
        Refused<ArgumentNullException>(() => remap.Sample(11, null), "position");
        Expect(remap.Counts().Steps == 0, "a refused call has begun a step");
        try
        {
            remap.Segment(10);
            remap.Segment(9);
        }
        catch (RemapException error)
        {
            Expect(error.Code == RemapCode.Order, "code " + error.Code);
        }
        remap.Dispose();
        remap.Dispose();
        Refused<ObjectDisposedException>(() => remap.Sample(12, value), "");
        Refused<ObjectDisposedException>(() => remap.Counts(), "");
    }

    // --- what a tick and a step allocate: nothing that would ever start a collection ---------------------------------

    private static int CollectionsOf(Action<long> call)
    {
        for (long i = 0; i < 100; ++i) call(i); // what is compiled at first
        int before = GC.CollectionCount(0);
        for (long i = 100; i < 1000000; ++i) call(i);
        return GC.CollectionCount(0) - before;
    }

    private static object kept;

    private static void Allocations()
    {
        RemapOptions options = RemapOptions.Defaults();
        options.LatencyNs = 20000000;
        var position = new double[3];
        var force = new double[3];
        using (var remap = new Remap(options))
        using (var clocked = new Remap(options, StepClock.OfStep(0.001)))
        {
            int collections = CollectionsOf(i =>
            {
                long nowNs = i * 1000000;
                remap.Sample(nowNs, position);
                remap.Force(nowNs, force);
                if (i % 10 == 0) remap.Segment(nowNs);
                remap.BeginStep(nowNs, position);
                remap.EndStep(nowNs, force);
                clocked.Sample(nowNs, position);
                clocked.BeginStepAt(nowNs, nowNs, position);
                clocked.EndStep(nowNs, force);
                clocked.Counts();
            });
            Expect(collections == 0, collections + " collections in a million ticks and steps");
        }
        Expect(CollectionsOf(i => kept = new double[1]) > 0 && kept != null, "a program that does allocate is not seen");
    }

    // --- a device thread and a simulation thread, and an error that belongs to its own thread ------------------------

    private static void Threads()
    {
        RemapOptions options = RemapOptions.Defaults();
        options.LatencyNs = 20000000;
        var remap = new Remap(options);
        bool done = false;
        Exception thrown = null;
        var device = new Thread(() =>
        {
            var value = new double[3];
            try
            {
                for (long tick = 0; !Volatile.Read(ref done); ++tick)
                {
                    remap.Sample(tick * 1000000, value);
                    remap.Force(tick * 1000000, value);
                    Refused<RemapException>(() => remap.Sample(-1, value), "evenstep_remap_sample: now_ns is -1 ns");
                }
            }
            catch (Exception error)
            {
                thrown = error;
            }
        });
        device.Start();
        var hand = new double[3];
        for (long n = 0; n < 20000; ++n)
        {
            remap.BeginStep(n * 1000000, hand);
            remap.EndStep(n * 1000000, hand);
            Refused<RemapException>(() => remap.EndStep(0, hand), "evenstep_remap_end_step: no step has begun");
        }
        Volatile.Write(ref done, true);
        device.Join();
        Expect(thrown == null, "the device thread: " + thrown);
        Expect(remap.Counts().Steps == 20000, "other steps: " + remap.Counts().Steps);
        remap.Dispose();
    }
}
