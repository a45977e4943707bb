#include "process_answer.h"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "excerpt.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kAnswerHead = 32, kVector = 24, kContact = 136;

template <class Integer>
void put(std::string& bytes, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}
void put(std::string& bytes, double value) { put(bytes, std::bit_cast<std::uint64_t>(value)); }

/// Takes numbers from the begin of some bytes, of which there are enough.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : left_(bytes) {}
  template <class Integer>
  Integer integer() {
    Integer value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) {
      value |= static_cast<Integer>(static_cast<Integer>(static_cast<unsigned char>(left_[i])) << (8 * i));
    }
    left_.remove_prefix(sizeof value);
    return value;
  }
  double number() { return std::bit_cast<double>(integer<std::uint64_t>()); }
  glm::dvec3 vector() {
    const double x = number(), y = number();
    return {x, y, number()};
  }

 private:
  std::string_view left_;
};

ToolContact contact_from(Bytes& bytes) {
  ToolContact contact;
  contact.touching = bytes.integer<std::uint32_t>() != 0;
  contact.unilateral = bytes.integer<std::uint32_t>() != 0;
  contact.point_m = bytes.vector();
  contact.normal = bytes.vector();
  contact.gap_m = bytes.number();
  for (int column = 0; column < 3; ++column) contact.stiffness_N_per_m[column] = bytes.vector();
  return contact;
}

const char* name_of(LocalModel model) {
  return model == LocalModel::none ? "none" : model == LocalModel::settled ? "settled" : "instantaneous";
}

}  // namespace

std::string greeting(const SolverRequest& request) {
  const nlohmann::ordered_json line = {{"protocol", kProcessProtocol},
                                       {"tools", request.tool_count},
                                       {"step_s", request.step_s},
                                       {"variable_step", request.variable_step},
                                       {"local_model", name_of(request.local_model)},
                                       {"seed", request.seed},
                                       {"options", nlohmann::ordered_json::parse(request.options)}};
  return line.dump() + "\n";
}

Result<SolverCapabilities, std::string> read_greeting(std::string_view line) {
  const auto failed = [&](const std::string& why) {
    return Failure(fmt::format("the first line of its standard output {}: '{}'", why, excerpt(line, 120)));
  };
  const nlohmann::json answer = nlohmann::json::parse(line, nullptr, false);
  if (!answer.is_object()) return failed("is no JSON object");
  if (!answer.contains("protocol")) return failed("has no \"protocol\"");
  if (answer["protocol"] != kProcessProtocol) return failed(fmt::format("does not say \"protocol\": {}", kProcessProtocol));
  SolverCapabilities has;
  for (const auto& [key, value] : answer.items()) {
    if (key != "protocol" && key != "has") return failed("has a key that is neither \"protocol\" nor \"has\"");
    if (key == "protocol") continue;
    if (!value.is_array()) return failed("has a \"has\" that is no list");
    for (const nlohmann::json& name : value) {
      bool* const member = name == "contacts"       ? &has.contacts
                           : name == "state_digest" ? &has.state_digest
                           : name == "energy"       ? &has.energy
                           : name == "reset"        ? &has.reset
                                                    : nullptr;
      if (member == nullptr)
        return failed("has something else than \"contacts\", \"state_digest\", \"energy\" and \"reset\" in \"has\"");
      *member = true;
    }
  }
  return has;
}

std::string request_record(RequestKind kind, std::uint64_t n, double step_s, std::span<const glm::dvec3> positions_m) {
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(kind));
  put(bytes, std::uint32_t{0});
  put(bytes, n);
  put(bytes, step_s);
  for (const glm::dvec3& at : positions_m) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, at[axis]);
  }
  return bytes;
}

std::size_t answer_size(std::size_t tools, bool contacts) {
  return kAnswerHead + tools * (kVector + (contacts ? kContact : 0));
}

Result<ProcessAnswer, std::string> read_answer(std::string_view bytes, std::size_t tools, bool contacts, RequestKind kind,
                                               std::uint64_t n) {
  const std::string_view all = bytes;
  Bytes from(bytes);
  ProcessAnswer answer;
  const auto of_kind = from.integer<std::uint32_t>();
  answer.status = from.integer<std::uint32_t>();
  const auto of_n = from.integer<std::uint64_t>();
  if (of_kind != static_cast<std::uint32_t>(kind) || of_n != n)
    return Failure(
        fmt::format("its answer begins with kind {} and number {}, and it was asked for kind {} and number {}; "
                    "as text it begins '{}'",
                    of_kind, of_n, static_cast<std::uint32_t>(kind), n, excerpt(all, 40)));
  answer.state_digest = from.integer<std::uint64_t>();
  answer.energy_J = from.number();
  for (std::size_t tool = 0; tool < tools; ++tool) answer.response.force_N[tool] = from.vector();
  for (std::size_t tool = 0; contacts && tool < tools; ++tool) answer.contacts.push_back(contact_from(from));
  return answer;
}

}  // namespace evenstep::internal
