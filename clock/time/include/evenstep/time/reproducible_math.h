#pragma once
/// exp, log, sin and cos made of IEEE-exact operations only (+ - * / sqrt), so that their bits are the same with every
/// C library and compiler (with -ffp-contract=off). libm's are not specified bit for bit, and what is hashed must be.
/// Accuracy: below 1 ulp on the domain stated, at the zeros of log, sin and cos too (tested against long double references).

namespace evenstep::reproducible {

double exp(double x);  ///< |x| <= 700; beyond: 0 or +infinity. NaN gives NaN.
double log(double x);  ///< x > 0 finite (subnormals included); otherwise NaN.
double sin(double x);  ///< |x| <= 1e6 rad; beyond: NaN (argument reduction would lose digits).
double cos(double x);  ///< as sin.

}  // namespace evenstep::reproducible
