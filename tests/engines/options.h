#pragma once
// The options of a scenario as the engines read them. An option that is not given keeps its default; an unknown one is an
// error.

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <glm/vec3.hpp>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "evenstep/sim/solver.h"

namespace engines {

/// The scene of a [case]: equal particles, each pair joined by a linear spring of the same stiffness.
struct Particles {
  explicit Particles(const nlohmann::json& json) : mass_kg(json.at("mass")), stiffness_N_per_m(json.at("stiffness")) {
    const auto vectors = [](const nlohmann::json& list) {
      std::vector<glm::dvec3> all;
      for (const auto& v : list) all.emplace_back(v.at(0), v.at(1), v.at(2));
      return all;
    };
    rest_m = vectors(json.at("rest"));
    displacement_m = vectors(json.at("displacement"));
    is_fixed.assign(rest_m.size(), false);
    for (const auto& n : json.at("fixed")) is_fixed.at(n) = true;
    for (const auto& pair : json.at("springs")) springs.emplace_back(pair.at(0), pair.at(1));
  }
  double mass_kg, stiffness_N_per_m;
  std::vector<glm::dvec3> rest_m, displacement_m;
  std::vector<bool> is_fixed;
  std::vector<std::pair<std::size_t, std::size_t>> springs;
};

class Options {
 public:
  Options(const std::string& text, std::initializer_list<const char*> known) : json_(nlohmann::json::parse(text)) {
    for (const auto& [key, value] : json_.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end())
        throw evenstep::SolverError(evenstep::SolverFault::bad_scene, fmt::format("there is no option '{}'", key),
                                    fmt::format("one of {}", fmt::join(known, ", ")));
    }
  }
  /// The value of an option that must lie within [least, most].
  double number(const char* key, double otherwise, double least, double most) const {
    if (!json_.contains(key)) return otherwise;
    const nlohmann::json& value = json_.at(key);
    if (value.is_number() && value >= least && value <= most) return value;
    throw evenstep::SolverError(evenstep::SolverFault::bad_scene, fmt::format("'{}' is {}", key, value.dump()),
                                fmt::format("a number from {} to {}", least, most));
  }
  int count(const char* key, int otherwise, int least, int most) const {
    return static_cast<int>(number(key, otherwise, least, most));
  }
  bool flag(const char* key, bool otherwise) const { return json_.value(key, otherwise); }
  /// One of the words; the first one if the option is not given.
  std::string word(const char* key, std::initializer_list<const char*> words) const {
    const std::string value = json_.value(key, *words.begin());
    if (std::find(words.begin(), words.end(), value) != words.end()) return value;
    throw evenstep::SolverError(evenstep::SolverFault::bad_scene, fmt::format("'{}' is \"{}\"", key, value),
                                fmt::format("one of {}", fmt::join(words, ", ")));
  }
  /// True if a [case] gives the scene. Then there is no model to choose.
  bool has_particles() const { return json_.contains("particles"); }
  Particles particles() const { return Particles(json_.at("particles")); }

 private:
  nlohmann::json json_;
};

}  // namespace engines
