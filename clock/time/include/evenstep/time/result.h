#pragma once
/// A value, or an error that says why there is none. Errors that a user's text, file or device can cause are returned in
/// this way, and the caller checks before it takes the value. Taking a value or an error that is not there is a programming
/// error (asserted). It is used like std::expected of C++23.
///
///   Result<Duration> parse_duration(std::string_view text);
///   ...
///   if (!is_number) return Failure("'" + text + "' is no number");
///   return Duration{ns};

#include <cassert>
#include <concepts>
#include <string>
#include <utility>
#include <variant>

namespace evenstep {

/// The error of a Result. Its type must be convertible to the error type of that Result.
template <class E>
struct Failure {
  E error;
  explicit Failure(E why) : error(std::move(why)) {}
};
Failure(const char*)->Failure<std::string>;

template <class T, class E = std::string>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  template <std::convertible_to<E> F>
  Result(Failure<F> failure) : content_(std::in_place_index<1>, std::move(failure.error)) {}

  bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& { return assert(ok()), *std::get_if<0>(&content_); }
  T& value() & { return assert(ok()), *std::get_if<0>(&content_); }
  T value() && { return assert(ok()), std::move(*std::get_if<0>(&content_)); }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }
  /// The value, or `other` if there is none.
  T value_or(T other) const& { return ok() ? *std::get_if<0>(&content_) : std::move(other); }
  T value_or(T other) && { return ok() ? std::move(*std::get_if<0>(&content_)) : std::move(other); }

  const E& error() const& { return assert(!ok()), *std::get_if<1>(&content_); }
  E error() && { return assert(!ok()), std::move(*std::get_if<1>(&content_)); }
  /// The error, or `none` if there is a value.
  E error_or(E none) const { return ok() ? std::move(none) : *std::get_if<1>(&content_); }

 private:
  std::variant<T, E> content_;
};

}  // namespace evenstep
