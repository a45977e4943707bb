// Puts the grabbed particles where their tools are.
__kernel void grab(GRABS, WRITE(u), WRITE(v)) {
  const uint n = get_global_id(0);
  if (n < count) PUT_GRABBED(n)
}
