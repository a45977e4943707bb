#include "evenstep/time/digest.h"

#include "catch.h"

using namespace evenstep;

TEST_CASE("spread and name_digest give the published values of their algorithms") {
  // The function fmix64 of murmur3, and the test vectors of FNV-1a (Noll).
  CHECK(spread(0) == 0);
  CHECK(spread(1) == 0xb456bcfc34c2cb2cULL);
  CHECK(name_digest("") == 0xcbf29ce484222325ULL);
  CHECK(name_digest("a") == 0xaf63dc4c8601ec8cULL);
  CHECK(name_digest("foobar") == 0x85944171f73967e8ULL);
}

TEST_CASE("a digest names the order of words and the sign of zero") {
  CHECK(mix(mix(0, std::uint64_t{1}), std::uint64_t{2}) != mix(mix(0, std::uint64_t{2}), std::uint64_t{1}));
  CHECK(mix(0, 0.0) != mix(0, -0.0));
  CHECK(mix(0, 1.0) == mix(0, std::uint64_t{0x3ff0000000000000}));
  CHECK(mix(0, std::uint64_t{0}) != 0);
}

TEST_CASE("the chain has the value that recorded trace hashes depend on") {
  std::uint64_t chain = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) chain = mix(chain, i);
  CHECK(chain == 0x389706723e36e2f5ULL);
}
