// The file of a reference: a first line, the key, the numbers, and a checksum over all of it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <type_traits>

#include "evenstep/harness/version.h"
#include "evenstep/text/text_file.h"
#include "evenstep/time/digest.h"
#include "reference.h"

namespace evenstep::internal {
namespace {
namespace fs = std::filesystem;

constexpr std::string_view kFirstLine = "evenstep reference of the felt force 1\n";  // 1: the version of this format

std::string text_of(const glm::dvec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

// The fields are bound one by one, so that a new one does not compile until it is in the key.

std::string text_of(const FixedFaces& faces) {
  const auto& [x_min, x_max, y_min, y_max, z_min, z_max] = faces;
  return fmt::format("{:d}{:d}{:d}{:d}{:d}{:d}", x_min, x_max, y_min, y_max, z_min, z_max);
}

std::string text_of(const ToolCoupling& tool) {
  const auto& [center_m, radius_m, kind, stiffness, damping] = tool;
  return fmt::format("{} {} {} {} {}", text_of(center_m), radius_m, static_cast<int>(kind), stiffness, damping);
}

std::string text_of(const MaterialRegion& region) {
  const auto& [min_m, max_m, stiffness, mass] = region;
  return fmt::format("{} {} {} {}", text_of(min_m), text_of(max_m), stiffness, mass);
}

std::uint64_t digest_of(const std::vector<glm::dvec3>& all) {
  std::uint64_t h = mix(0, static_cast<std::uint64_t>(all.size()));
  for (const glm::dvec3& v : all) h = mix(mix(mix(h, v.x), v.y), v.z);
  return h;
}

/// Without what the reference chooses for itself: method, iterations and substeps.
std::string text_of(const TissueScene& tissue) {
  const auto& [lattice, particles, spacing, mass, stiffness, damping, axial, gravity, regions, fixed, method, iterations,
               substeps, tools, displaced, moving] = tissue;
  std::string text = fmt::format("tissue {} {} {} {} {} {} {} {} fixed {}", fmt::join(lattice, "x"), particles, spacing,
                                 mass, stiffness, damping, axial, text_of(gravity), text_of(fixed));
  for (const MaterialRegion& region : regions) text += "\nregion " + text_of(region);
  for (const ToolCoupling& tool : tools) text += "\ntool " + text_of(tool);
  return text + fmt::format("\nbegins {:016x} {:016x}", digest_of(displaced), digest_of(moving));
}

std::uint64_t digest_of_motions(const Scenario& scenario, const ReferencePlan& plan) {
  std::uint64_t h = mix(0, static_cast<std::uint64_t>(scenario.devices.size()));
  for (const DeviceSpec& device : scenario.devices) {
    for (std::int64_t j = 0; tick_time(plan.rate, j) < plan.until; ++j) {
      const glm::dvec3 at_m = position_m(device.motion, tick_time(plan.rate, j));
      h = mix(mix(mix(h, at_m.x), at_m.y), at_m.z);
    }
  }
  return h;
}

std::string checksum_line(std::string_view text) { return fmt::format("checksum {:016x}\n", name_digest(text)); }

/// Takes numbers from a text, one after the other.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}
  template <class Number>
  Number next() {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\n')) ++at_;
    Number number{};
    const auto [after, error] = std::from_chars(at_, end_, number);
    good_ &= error == std::errc();
    at_ = after;
    return number;
  }
  bool all_good() const { return good_; }

 private:
  const char *at_, *end_;
  bool good_ = true;
};

std::string numbers_of(const FeltReference& reference) {
  const FeltReferenceInfo& info = reference.info;
  std::string text = fmt::format("{} {} {} {} {}\n", info.coarsest_step_s, info.method_order, info.estimate_N, info.cpu_s,
                                 reference.forces.read.size());
  for (std::size_t j = 0; j < reference.forces.read.size(); ++j) {
    text += fmt::format("{}", reference.forces.read[j].ns);
    for (const glm::dvec3& force_N : reference.forces.force_N[j])
      fmt::format_to(std::back_inserter(text), " {} {} {}", force_N.x, force_N.y, force_N.z);
    text += '\n';
  }
  return text;
}

bool take_numbers(std::string_view text, FeltReference& reference) {
  Numbers numbers(text);
  reference.info.coarsest_step_s = numbers.next<double>();
  reference.info.method_order = numbers.next<int>();
  reference.info.estimate_N = numbers.next<double>();
  reference.info.cpu_s = numbers.next<double>();
  const auto count = numbers.next<std::size_t>();
  for (std::size_t j = 0; j < count && numbers.all_good(); ++j) {
    reference.forces.read.push_back({numbers.next<std::int64_t>()});
    auto& force_N = reference.forces.force_N.emplace_back();
    for (glm::dvec3& f : force_N) f = {numbers.next<double>(), numbers.next<double>(), numbers.next<double>()};
  }
  return numbers.all_good() && count > 0;
}

}  // namespace

std::string reference_key(const Scenario& scenario, const ReferencePlan& plan) {
  return fmt::format("version {}\nmethod {}, {}/{} steps per second, up to {} ns\n{}\nmotions {:016x}\n", kVersion,
                     name_of(plan.method), plan.rate.num, plan.rate.den, plan.until.ns,
                     text_of(std::get<TissueScene>(scenario.scene.body)), digest_of_motions(scenario, plan));
}

std::string reference_file(const std::string& folder, const std::string& key) {
  return (fs::path(folder) / fmt::format("reference-{:016x}.txt", name_digest(key))).string();
}

bool read_reference(const std::string& file, const std::string& key, FeltReference& reference, std::string& objection) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return false;
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::string begin = std::string(kFirstLine) + key;
  const std::size_t end = text.rfind("checksum ");
  if (end == std::string::npos || text.substr(end) != checksum_line(std::string_view(text).substr(0, end))) {
    objection = "its checksum is wrong";
  } else if (!text.starts_with(kFirstLine)) {
    objection = "it is of another version of this format";
  } else if (!text.starts_with(begin)) {
    objection = "it is of another scene, motion or version";
  } else if (!take_numbers(std::string_view(text).substr(begin.size(), end - begin.size()), reference)) {
    objection = "its numbers cannot be read";
  }
  return objection.empty();
}

std::string write_reference(const std::string& file, const std::string& key, const FeltReference& reference) {
  std::error_code error;
  fs::create_directories(fs::path(file).parent_path(), error);
  if (error) return error.message();
  const std::string text = std::string(kFirstLine) + key + numbers_of(reference);
  return write_text_file(file, text + checksum_line(text));
}

}  // namespace evenstep::internal
