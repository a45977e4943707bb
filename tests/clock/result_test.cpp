#include "evenstep/time/result.h"

#include <memory>
#include <vector>

#include "catch.h"

using namespace evenstep;

namespace {

Result<int> half(int number) {
  if (number % 2 != 0) return Failure("odd");
  return number / 2;
}

}  // namespace

TEST_CASE("a result holds its value or its error, never both") {
  for (int i = -10; i <= 10; ++i) {
    const Result<int> result = half(i);
    CHECK(result.ok() == (i % 2 == 0));
    CHECK(static_cast<bool>(result) == result.ok());
    CHECK(result.value_or(99) == (i % 2 == 0 ? i / 2 : 99));
    CHECK(result.error_or("none") == (i % 2 == 0 ? "none" : "odd"));
    if (result) CHECK((*result == i / 2 && result.value() == i / 2));
    if (!result) CHECK(result.error() == "odd");
  }
}

TEST_CASE("value and error may be of one type, and what can only be moved is moved out") {
  const Result<std::string> error = Failure("x"), value = std::string("x");
  CHECK_FALSE(error);
  CHECK(value);
  Result<std::unique_ptr<int>, std::vector<int>> owned = std::make_unique<int>(7);
  CHECK(**owned == 7);
  const std::unique_ptr<int> taken = *std::move(owned);
  CHECK(*taken == 7);
  const Result<int, std::vector<int>> many = Failure(std::vector<int>{1, 2});
  CHECK(many.error().size() == 2);
}
