// The summary of points: bounds, worst points, and the value that is found.
#include <fmt/format.h>

#include <cmath>

#include "catch.h"
#include "evenstep/reports/sweep_record.h"

using namespace evenstep;
using Catch::Contains;

namespace {

struct SweepRecord {
  SweepHeader header;
  std::vector<SweepPoint> points;
};

SweepSummary summarize(const SweepRecord& record) {
  SweepSummarizer summarizer(record.header);
  for (const SweepPoint& point : record.points) summarizer.add(point);
  return summarizer.summary();
}

/// A record from rows of p (pass), f (fail) and e (error): one row per value of an axis, one letter per seed. The values of
/// the axis for `find` are 1, 2, 3 ...
SweepRecord record_of(const std::vector<std::string>& rows, bool smallest = true, std::size_t allowed = 100) {
  SweepRecord record;
  for (std::size_t seed = 0; seed < rows.front().size(); ++seed) record.header.seeds.push_back(seed);
  record.header.expectations = {{"s", "m", "ms"}};
  SweepHeader::Axis axis{"k", {}};
  std::int64_t index = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    axis.values.push_back(std::to_string(i + 1));
    for (const char c : rows[i]) {
      SweepPoint point;
      point.index = index++;
      point.verdict = c == 'p' ? SweepVerdict::pass : c == 'f' ? SweepVerdict::fail : SweepVerdict::error;
      if (c != 'e') point.expect = {{c == 'p' ? 1.0 : 3.0, std::nullopt, 2.0, point.verdict}};
      record.points.push_back(point);
    }
  }
  record.header.grid = {axis};
  record.header.find = {0, smallest, "x", std::min(allowed, rows.size())};
  return record;
}

SweepSummary::Find found(const std::vector<std::string>& rows, bool smallest = true, std::size_t allowed = 100) {
  return *summarize(record_of(rows, smallest, allowed)).find;
}

double binomial_cdf(std::int64_t hits, std::int64_t runs, double p) {
  double sum = 0;
  for (std::int64_t k = 0; k <= hits; ++k) {
    const double choose = std::lgamma(runs + 1.0) - std::lgamma(k + 1.0) - std::lgamma(runs - k + 1.0);
    sum += std::exp(choose + static_cast<double>(k) * std::log(p) + static_cast<double>(runs - k) * std::log1p(-p));
  }
  return sum;
}

}  // namespace

TEST_CASE("The upper bound of a rate is the p with which so few hits have probability one in twenty") {
  for (const std::int64_t runs : {1, 2, 10, 100, 1000, 30000}) {
    for (const std::int64_t hits : {0, 1, 2, 9, 500}) {
      if (hits >= runs) continue;
      INFO(hits << " of " << runs);
      CHECK(binomial_cdf(hits, runs, rate_at_most(hits, runs)) == Approx(0.05).epsilon(1e-6));
    }
    CHECK(rate_at_most(runs, runs) == 1);
  }
  CHECK(rate_at_most(0, 29'956) <= 1e-4);
  CHECK(rate_at_most(0, 29'955) > 1e-4);
}

TEST_CASE("The smallest value is the one from which on every seed passes") {
  const auto monotone = found({"ff", "pf", "pp", "pp"});
  CHECK(monotone.value == 2U);
  CHECK(monotone.beyond == 0);
  CHECK(monotone.within_gate);
  const auto with_island = found({"ff", "pp", "fp", "pp"});
  CHECK(with_island.value == 3U);
  CHECK(with_island.beyond == 1);
  CHECK_FALSE(found({"pp", "pp", "pf"}).value);
  CHECK(found({"pp", "pp", "pf"}).beyond == 2);
  CHECK(found({"pp", "pp"}).value == 0U);
  CHECK(found({"pe", "pp"}).value == 1U);  // what could not be judged does not pass
}

TEST_CASE("The largest value is the one up to which every seed passes") {
  CHECK(found({"pp", "pp", "pf", "ff"}, false).value == 1U);
  CHECK(found({"pp", "pf", "pp", "ff"}, false).value == 0U);
  CHECK(found({"pp", "pf", "pp", "ff"}, false).beyond == 1);
  CHECK_FALSE(found({"pf", "pp"}, false).value);
}

TEST_CASE("A value outside its gate is not what was asked for") {
  const std::vector<std::string> rising{"ff", "ff", "pp", "pp"}, falling{"pp", "pp", "ff", "ff"};
  for (std::size_t allowed = 1; allowed <= 4; ++allowed) {
    INFO(allowed);
    CHECK(found(rising, true, allowed).within_gate == (allowed >= 3));    // the first `allowed` values are small enough
    CHECK(found(falling, false, allowed).within_gate == (allowed >= 3));  // the last ones are large enough
  }
  CHECK_FALSE(found({"ff", "pf"}).within_gate);
  CHECK_THAT(sweep_text(record_of(rising, true, 2).header, summarize(record_of(rising, true, 2)), [](auto&) { return ""; }),
             Contains("smallest k: 3, but at most x is asked for"));
}

TEST_CASE("Worst points come by share of the limit and then by number, what did not pass before what did") {
  SweepRecord record = record_of({"pppppp"});
  record.header.find.reset();
  record.header.keep_worst = 6;
  const auto set = [&](std::size_t i, SweepVerdict verdict, std::vector<SweepPoint::Value> values) {
    record.points[i].verdict = verdict;
    record.points[i].expect = std::move(values);
  };
  using V = SweepVerdict;
  set(0, V::pass, {{1.0, std::nullopt, 2.0, V::pass}});  // 50 % below
  set(1, V::pass, {{1.9, std::nullopt, 2.0, V::pass}});  // 5 % below
  set(2, V::fail, {{3.0, std::nullopt, 2.0, V::fail}});  // 50 % over
  set(3, V::fail, {{1.0, 2.0, std::nullopt, V::fail}});  // 50 % below its least
  set(4, V::error, {});
  set(5, V::fail, {{9.0, std::nullopt, 2.0, V::fail}});
  std::vector<std::int64_t> order;
  for (const auto& worst : summarize(record).worst) order.push_back(worst.point.index);
  CHECK(order == std::vector<std::int64_t>{4, 5, 2, 3, 1, 0});
  record.header.keep_worst = 2;
  CHECK(summarize(record).worst.size() == 2);
}

TEST_CASE("A point's number says its values and its seed") {
  SweepHeader header;
  header.seeds = {7, 9};
  header.grid = {{"a", {"1", "2", "3"}}, {"b", {"x", "y"}}};
  REQUIRE(header.points() == 12);
  std::int64_t index = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 2; ++b) {
      for (const std::uint64_t seed : header.seeds) {
        CHECK(header.value_of(index, 0) == a);
        CHECK(header.value_of(index, 1) == b);
        CHECK(header.seed_of(index++) == seed);
      }
    }
  }
}
