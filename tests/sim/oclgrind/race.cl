// Each work-item reads what its neighbour writes: what the detector must report.
__kernel void race(__global int* values) {
  const size_t i = get_global_id(0);
  values[i] = values[(i + 1) % get_global_size(0)] + 1;
}
