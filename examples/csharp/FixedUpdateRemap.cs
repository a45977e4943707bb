using System;
using Evenstep;
using UnityEngine;

/// <summary>A component of Unity whose FixedUpdate reads the hand, and plays its force, in even time. Unity calls
/// FixedUpdate before a picture as often as it is due, so the real times of steps are uneven; each step's own simulation
/// time is even, and the map clocked puts the step there. Unity 2020.2 or later, Time.timeScale 1.</summary>
public class FixedUpdateRemap : MonoBehaviour
{
    /// <summary>ns; <c>evenstep size timing.csv --step-size "20 ms"</c> prints both for a recording of the game.</summary>
    public long LeadNs = 1000000;
    /// <summary>ns.</summary>
    public long LatencyNs = 40000000;
    /// <summary>Of the spring that stands for a simulation here.</summary>
    public double StiffnessNPerM = 200;
    /// <summary>The clock of both threads, ns.</summary>
    public Func<long> NowNs = SteadyClock.NowNs;

    private readonly double[] handM = new double[3], forceN = new double[3]; // made once: FixedUpdate allocates nothing
    private Remap remap;
    private RemapCounts told;

    /// <summary>Device thread, every tick: where the hand is, and the force to play. Start the thread after Awake, and stop
    /// it before OnDestroy.</summary>
    public void Tick(long nowNs, double[] positionM, double[] forceToPlayN)
    {
        remap.Sample(nowNs, positionM);
        remap.Force(nowNs, forceToPlayN);
    }

    /// <summary>What has happened so far. Any thread.</summary>
    public RemapCounts Counts() { return remap.Counts(); }

    /// <summary>What the simulation computes in a step; here a spring.</summary>
    protected virtual void Step(double[] handOfStepM, double[] forceOfStepN)
    {
        for (int i = 0; i < handOfStepM.Length; ++i) forceOfStepN[i] = -StiffnessNPerM * handOfStepM[i];
    }

    // Unity calls these four, whoever else may.
    internal void Awake()
    {
        RemapOptions options = RemapOptions.Defaults();
        options.LeadNs = LeadNs;
        options.LatencyNs = LatencyNs;
        remap = new Remap(options, StepClock.OfStep(Time.fixedDeltaTime));
    }

    internal void FixedUpdate()
    {
        // t(n): the step's own time, which goes on where the game drops time after a hitch (Time.fixedTime does not).
        long simulatedNs = (long)Math.Round(Time.fixedUnscaledTimeAsDouble * 1e9);
        remap.BeginStepAt(NowNs(), simulatedNs, handM);
        Step(handM, forceN);
        remap.EndStep(NowNs(), forceN);
    }

    internal void Update()
    {
        RemapCounts counts = remap.Counts();
        if (counts.LateForces > told.LateForces)
            Debug.LogWarning("a force was late by " + counts.LatestForceNs + " ns: LatencyNs is too small");
        if (counts.HandHeld > told.HandHeld)
            Debug.LogWarning("the hand was read past its newest sample: LeadNs is too small");
        told = counts;
    }

    internal void OnDestroy()
    {
        if (remap != null) remap.Dispose();
    }
}
