// The front of choices is as its definition says, and every choice that is beaten is beaten by one on the front.
#include "evenstep/reports/pareto.h"

#include <algorithm>

#include "catch.h"
#include "evenstep/scheduler/random.h"

using namespace evenstep;

namespace {

using Table = std::vector<std::vector<double>>;

/// The definition, pair by pair.
bool beats(const std::vector<double>& a, const std::vector<double>& b) {
  bool better = false;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (a[k] > b[k]) return false;
    better = better || a[k] < b[k];
  }
  return better;
}

/// Up to 40 choices with up to 6 prices of few values, so that many tie.
Table random_table(std::uint64_t seed) {
  const RandomStream stream(seed, "pareto.test");
  std::uint64_t draw = 0;
  const auto pick = [&](std::uint64_t count) { return stream.bits(draw++) % count; };
  const std::uint64_t choices = pick(41), prices = pick(6) + 1, values = pick(9) + 1;
  Table table(choices, std::vector<double>(prices));
  for (auto& row : table) {
    for (double& price : row) price = static_cast<double>(pick(values)) - 4;
  }
  return table;
}

}  // namespace

TEST_CASE("the front of 5000 random tables is that of the definition, ties included") {
  std::size_t fronts = 0, beaten = 0, tied = 0;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    const Table table = random_table(seed);
    const std::vector<ParetoPlace> places = pareto(table);
    REQUIRE(places.size() == table.size());
    std::vector<bool> front(table.size(), true);
    for (std::size_t i = 0; i < table.size(); ++i) {
      for (const auto& other : table) front[i] = front[i] && !beats(other, table[i]);
    }
    for (std::size_t i = 0; i < table.size(); ++i) {
      std::vector<std::size_t> by, ties;
      for (std::size_t j = 0; j < table.size(); ++j) {
        if (front[j] && beats(table[j], table[i])) by.push_back(j);
        if (i != j && table[i] == table[j]) ties.push_back(j);
      }
      INFO("seed " << seed << ", choice " << i);
      REQUIRE(places[i].on_front == front[i]);
      REQUIRE(places[i].dominated_by == by);
      REQUIRE(places[i].ties == ties);
      REQUIRE(front[i] == by.empty());
      fronts += front[i] ? 1 : 0;
      beaten += front[i] ? 0 : 1;
      tied += ties.empty() ? 0 : 1;
    }
  }
  // All three cases occur in the tables.
  CHECK(fronts > 10'000);
  CHECK(beaten > 10'000);
  CHECK(tied > 10'000);
}

TEST_CASE("a price that two choices share does not keep either off the front") {
  const std::vector<ParetoPlace> places = pareto({{1, 5}, {2, 4}, {2, 5}, {1, 5}});
  CHECK(places[0].on_front);
  CHECK(places[0].ties == std::vector<std::size_t>{3});
  CHECK(places[1].on_front);
  CHECK_FALSE(places[2].on_front);
  CHECK(places[2].dominated_by == std::vector<std::size_t>{0, 1, 3});
  CHECK(places[3].on_front);
  CHECK(pareto({}).empty());
}
