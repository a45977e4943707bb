// A logistic map: each round needs the one before, so no compiler can leave rounds out.
kernel void burn(global float* results, int rounds) {
  float x = 0.25f + 1e-6f * (float)(get_global_id(0) % 1000);
  for (int n = 0; n < rounds; ++n) x = 3.9f * x * (1.0f - x);
  results[get_global_id(0)] = x;
}
