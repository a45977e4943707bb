// What FixedUpdateRemap.cs uses of Unity, for compilers elsewhere.
#if !UNITY_5_3_OR_NEWER
namespace UnityEngine
{
    /// <summary>The base of components.</summary>
    public class MonoBehaviour
    {
    }

    /// <summary>The times of the game's loop, which Program.cs sets.</summary>
    public static class Time
    {
        /// <summary>The size of a step, s.</summary>
        public static float fixedDeltaTime = 0.02f;
        /// <summary>The simulation time of the step that runs, s, with what was dropped.</summary>
        public static double fixedUnscaledTimeAsDouble;
    }

    /// <summary>The console.</summary>
    public static class Debug
    {
        /// <summary>Prints a line.</summary>
        public static void LogWarning(object message) { System.Console.Error.WriteLine(message); }
    }
}
#endif
