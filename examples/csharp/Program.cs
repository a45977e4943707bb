// Unity's loop without Unity, in programmed time: pictures at 60 Hz, each up to 2 ms late, and before each as many steps of
// 20 ms as are due. A device ticks at 1 kHz, and its hand moves evenly. Steps that read the hand when they run see it jump;
// FixedUpdateRemap sees a line.
//
//     mono fixed_update.exe [LATENCY_NS]       exits with 1 if it is no line, or a force was late
#if !UNITY_5_3_OR_NEWER
using System;
using System.Globalization;
using Evenstep;
using UnityEngine;

internal sealed class Program : FixedUpdateRemap
{
    private const long Ms = 1000000;
    private const double StepM = 0.1 * 0.02; // the way of the hand in a step

    private readonly double[] positionM = new double[3], playedN = new double[3];
    private readonly VelocityJump direct = new VelocityJump(), read = new VelocityJump(), played = new VelocityJump();
    private long nowNs, nextTickNs;
    private ulong draws;

    private static int Main(string[] arguments)
    {
        var program = new Program();
        if (arguments.Length > 0) program.LatencyNs = long.Parse(arguments[0], CultureInfo.InvariantCulture);
        return program.Play() ? 0 : 1;
    }

    private bool Play()
    {
        long startNs = 0, dueNs = 0;
        NowNs = () => nowNs;
        Awake();
        for (long picture = 0; picture < 60 * 8; ++picture)
        {
            long frameNs = picture * 1000 * Ms / 60 + Draw(2 * Ms);
            if (picture == 0) startNs = frameNs;
            DeviceUntil(frameNs, false);
            for (; dueNs <= frameNs - startNs; dueNs += 20 * Ms)
            {
                Time.fixedUnscaledTimeAsDouble = dueNs * 1e-9;
                DeviceUntil(nowNs, true);
                FixedUpdate();
            }
            Update();
        }
        RemapCounts counts = Counts();
        OnDestroy();
        Console.WriteLine("velocity jump: direct {0} step; remapped {1} step in, {2} step out", Short(direct.Most / StepM),
            Short(read.Most / StepM), Short(played.Most / StepM / StiffnessNPerM));
        Console.WriteLine("{0} underruns, {1} late forces", counts.HandHeld, counts.LateForces);
        return direct.Most > 0.4 * StepM && read.Most < 1e-6 * StepM && played.Most < 1e-6 * StepM * StiffnessNPerM
            && counts.HandHeld == 0 && counts.LateForces == 0;
    }

    protected override void Step(double[] handOfStepM, double[] forceOfStepN)
    {
        direct.Add(HandM(nowNs), nowNs > 1000 * Ms);
        read.Add(handOfStepM[0], nowNs > 1000 * Ms);
        base.Step(handOfStepM, forceOfStepN);
        DeviceUntil(nowNs + Ms * 4 / 10, false); // so long it takes
    }

    // The ticks of the device before this time, and a tick at this very time if `including`. A game has a thread for them.
    private void DeviceUntil(long untilNs, bool including)
    {
        for (; nextTickNs < untilNs || (including && nextTickNs == untilNs); nextTickNs += Ms)
        {
            positionM[0] = HandM(nextTickNs);
            Tick(nextTickNs, positionM, playedN);
            played.Add(playedN[0], nextTickNs > 1000 * Ms);
        }
        nowNs = untilNs;
    }

    private static double HandM(long atNs) { return 1e-10 * atNs; } // 0.1 m/s

    // An even draw from 0 to most (splitmix64).
    private long Draw(long most)
    {
        ulong z = unchecked(++draws * 0x9E3779B97F4A7C15UL);
        z = unchecked((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9UL);
        z = unchecked((z ^ (z >> 27)) * 0x94D049BB133111EBUL);
        return (long)((z ^ (z >> 31)) % (ulong)(most + 1));
    }

    private static string Short(double value) { return value.ToString("0.0e+00", CultureInfo.InvariantCulture); }

    // The largest change of velocity of a signal, in its own unit.
    private sealed class VelocityJump
    {
        public double Most { get; private set; }
        private double last, before;

        public void Add(double value, bool judged)
        {
            if (judged) Most = Math.Max(Most, Math.Abs(value - 2 * last + before));
            before = last;
            last = value;
        }
    }
}
#endif
