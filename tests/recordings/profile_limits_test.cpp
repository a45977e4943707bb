// The limits of a file that is not trusted: what is just within a limit is read, one more is refused.
#include <sys/resource.h>

#include <fstream>

#include "catch.h"
#include "evenstep/recordings/roles.h"
#include "profile_texts.h"
#include "src/profiles/bytes.h"
#include "src/profiles/profile_builder.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::test;
using Catch::Contains;

namespace {

std::string refusal(ProfileBuilder& builder) {
  const ProfileResult profile = builder.finish();
  return profile ? "" : text(profile.error().front());
}

std::string repeated(const std::string& part, std::size_t times) {
  std::string all;
  all.reserve(part.size() * times);
  for (std::size_t i = 0; i < times; ++i) all += part;
  return all;
}

const std::string kEvent = R"({"ph":"X","name":"a","ts":1,"dur":2})";

}  // namespace

TEST_CASE("JSON may be nested 200 deep, and not 201") {
  // The list and the event are two of the levels.
  const auto nested = [](std::size_t depth) {
    return R"([{"ph":"X","name":"a","ts":1,"dur":2,"args":)" + std::string(depth - 2, '[') + std::string(depth - 2, ']') +
           "}]";
  };
  CHECK(refusal(nested(200)).empty());
  CHECK_THAT(refusal(nested(201)), Contains("nested more than 200 deep"));
}

TEST_CASE("A text in JSON may have 16 MiB with what is around it, and not more", "[sweep]") {
  const auto with = [](std::size_t length) { return "[" + kEvent + R"(,{"args":")" + std::string(length, 'x') + "\"}]"; };
  CHECK(refusal(with((std::size_t{16} << 20) - 100)).empty());
  CHECK_THAT(refusal(with((std::size_t{16} << 20) + 1)), Contains("a text in it is longer than 16777216 bytes"));
}

TEST_CASE("Of begins without an end there may be a million, and not one more", "[sweep]") {
  const auto begins = [](std::size_t count) {
    return "[" + kEvent + repeated(R"(,{"ph":"B","name":"b","ts":3})", count) + "]";
  };
  CHECK(refusal(begins(1'000'000)).empty());
  CHECK_THAT(refusal(begins(1'000'001)), Contains("more than 1000000 begins without an end"));
}

TEST_CASE("A line of CSV may have 1 MiB, and not a byte more") {
  const auto with = [](std::size_t length) {
    std::string line = "1,2,";
    return "ts,dur,name\n" + line + std::string(length - line.size(), 'x') + "\n";
  };
  CHECK(refusal(with(kLongestProfileLine)).empty());
  CHECK_THAT(refusal(with(kLongestProfileLine + 1)), Contains("line 2 is longer than 1048576 bytes"));
}

TEST_CASE("A name is kept with 1,000 bytes, and not within a character") {
  const auto kept = [](const std::string& name) {
    ProfileBuilder builder("x");
    builder.name(name, "");
    return builder.profile().names.front().text;
  };
  CHECK(kept(std::string(1000, 'x')).size() == 1000);
  CHECK(kept(std::string(1001, 'x')).size() == 1000);
  CHECK(kept(std::string(999, 'x') + "\xC3\xA4") == std::string(999, 'x'));
}

TEST_CASE("A million names are kept, or 64 MiB of them, and not one more", "[sweep]") {
  ProfileBuilder many("x"), long_ones("x");
  for (std::size_t i = 0; i < kMostNames; ++i) many.name(std::to_string(i), "");
  CHECK_FALSE(many.failed());
  many.name("0", "");  // a name that is known already
  CHECK_FALSE(many.failed());
  many.name("one more", "");
  CHECK_THAT(refusal(many), Contains("more than 1000000 different names"));
  const auto long_name = [](std::size_t i) { return std::to_string(1'000'000 + i) + std::string(kLongestName - 7, 'x'); };
  const std::size_t fit = kMostNameBytes / kLongestName;
  for (std::size_t i = 0; i < fit; ++i) long_ones.name(long_name(i), "");
  CHECK_FALSE(long_ones.failed());
  long_ones.name(long_name(fit), "");
  CHECK_THAT(refusal(long_ones), Contains("or 67108864 bytes of them"));
}

TEST_CASE("Ten thousand processes are kept, and not one more") {
  ProfileBuilder builder("x");
  for (std::size_t i = 0; i < kMostNames / 100; ++i) builder.track(std::to_string(i));
  CHECK_FALSE(builder.failed());
  builder.track("one more");
  CHECK_THAT(refusal(builder), Contains("more than 10000 processes"));
}

TEST_CASE("A role's expression may have 1,000 bytes, and not one more") {
  const ProfileResult profile = parse_profile("[" + kEvent + "," + kEvent + "]", "x");
  REQUIRE(profile);
  const auto with = [&](std::size_t length) {
    Roles roles;
    roles.step = "a|" + std::string(length - 2, 'x');
    const AssignedRolesResult assigned = assign_roles(*profile, roles);
    return assigned ? "" : text(assigned.error().front());
  };
  CHECK(with(1000).empty());
  CHECK_THAT(with(1001), Contains("longer than 1000 bytes"));
}

TEST_CASE("A gigabyte of trace events is read in less memory than a fifth of it", "[million]") {
  const testing::TemporaryFolder folder;
  const std::string path = folder.write("big.json", "");
  constexpr std::int64_t kBytes = std::int64_t{1} << 30;
  const std::string arguments = "\",\"args\":{\"stack\":\"" + std::string(400, 'x') + "\"}}";
  std::int64_t events = 0, written = 0;
  {
    std::ofstream file(path, std::ios::binary);
    file << "[";
    for (; written < kBytes; ++events) {
      const std::string event = (events > 0 ? ",\n" : "") + std::string(R"({"ph":"X","pid":1,"ts":)") +
                                std::to_string(events) + R"(,"dur":0.5,"name":"kernel )" + std::to_string(events % 100) +
                                arguments;
      written += static_cast<std::int64_t>(event.size());
      file << event;
    }
    file << "]";
  }
  {
    const ProfileResult profile = read_profile(path);
    REQUIRE(profile);
    CHECK(profile->intervals.size() == static_cast<std::size_t>(events));
  }
  rusage used{};
  REQUIRE(::getrusage(RUSAGE_SELF, &used) == 0);
  CHECK(used.ru_maxrss * 1024 < kBytes / 5);  // the maximum over the whole process
}

TEST_CASE("Ten million intervals are kept, and not one more", "[long]") {
  ProfileBuilder builder("x");
  const std::uint32_t name = builder.name("a", ""), track = builder.track("");
  for (std::size_t i = 0; i < kMostIntervals; ++i) builder.add(name, track, 0, 1);
  CHECK_FALSE(builder.failed());
  builder.add(name, track, 0, 1);
  CHECK_THAT(refusal(builder), Contains("more than 10000000 intervals"));
}
