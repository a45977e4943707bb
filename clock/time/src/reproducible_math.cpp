// clock/time/src/reproducible_math.cpp
