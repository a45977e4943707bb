// remap/src/buffer_oracle.cpp
