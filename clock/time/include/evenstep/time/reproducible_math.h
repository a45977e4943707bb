#pragma once
/// exp, log, sin and cos made only of operations that IEEE 754 defines exactly (+ - * / sqrt), so that their results have
/// the same bits with every C library and compiler (with -ffp-contract=off). libm's functions do not promise that, and
/// what goes into a trace hash needs it.
/// Error: below 1 ulp on the domain stated, near the zeros of log, sin and cos too (tested against long double references).

namespace evenstep::reproducible {

double exp(double x);  ///< |x| <= 700; beyond: 0 or +infinity. NaN gives NaN.
double log(double x);  ///< x > 0 finite (subnormals included); otherwise NaN.
double sin(double x);  ///< |x| <= 1e6 rad; beyond: NaN (argument reduction would lose digits).
double cos(double x);  ///< as sin.

}  // namespace evenstep::reproducible
