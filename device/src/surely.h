#pragma once
/// What a device must be told before it is left alone.

namespace evenstep::internal {

/// Calls until one call returns, twice at most. A simulated hand that has diverged says so once, by an exception, and the
/// device must be stopped nevertheless; a second one is ignored.
template <class Call>
void surely(Call call) noexcept {
  for (int tries = 0; tries < 2; ++tries) {
    try {
      call();
      return;
    } catch (...) {
    }
  }
}

}  // namespace evenstep::internal
