#include "evenstep/device/hid/pid_layout.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "catch.h"
#include "evenstep/device/hid/pid_descriptors.h"

using namespace evenstep;

namespace {

ReportDescriptor parsed_descriptor(const std::vector<std::byte>& bytes) {
  auto result = parse_report_descriptor(bytes);
  REQUIRE(result);
  return *std::move(result);
}

PidLayout layout_of(const PidDescriptorOptions& options) {
  const auto found = pid_layout(parsed_descriptor(pid_descriptor(options)));
  REQUIRE(found);
  return *found;
}

/// The first bit, counted from the report's first byte; the number of bits; the logical range.
using Place = std::array<std::int64_t, 4>;
Place place(const PidValue& value) {
  const FieldLayout& field = value.field;
  return {std::int64_t{8} + field.bit_offset + value.index * field.bits, field.bits, field.logical_minimum,
          field.logical_maximum};
}
std::pair<Place, std::int64_t> place(const PidChoice& choice) { return {place(choice.where), choice.value}; }

using Sizes = std::map<std::pair<ReportType, int>, std::size_t>;
Sizes sizes_of(const ReportDescriptor& descriptor) {
  Sizes sizes;
  for (const HidReport& report : descriptor.reports) sizes[{report.type, report.id}] = report.size();
  return sizes;
}

constexpr auto kIn = ReportType::input, kOut = ReportType::output, kFeat = ReportType::feature;

}  // namespace

TEST_CASE("both flavours' reports have their documented ids and sizes") {
  const ReportDescriptor mask = parsed_descriptor(pid_descriptor({PidFlavour::mask}));
  CHECK(sizes_of(mask) == Sizes{{{kIn, 1}, 6},
                                {{kIn, 2}, 2},
                                {{kOut, 0x10}, 22},
                                {{kOut, 0x12}, 15},
                                {{kOut, 0x14}, 4},
                                {{kOut, 0x16}, 4},
                                {{kOut, 0x17}, 2},
                                {{kOut, 0x18}, 2},
                                {{kOut, 0x19}, 2},
                                {{kFeat, 0x20}, 4},
                                {{kFeat, 0x21}, 5},
                                {{kFeat, 0x22}, 5}});
  const ReportDescriptor array = parsed_descriptor(pid_descriptor({PidFlavour::array}));
  CHECK(sizes_of(array) == Sizes{{{kIn, 1}, 5},
                                 {{kIn, 2}, 3},
                                 {{kOut, 1}, 18},
                                 {{kOut, 2}, 15},
                                 {{kOut, 3}, 4},
                                 {{kOut, 4}, 4},
                                 {{kOut, 5}, 2},
                                 {{kOut, 6}, 2},
                                 {{kOut, 7}, 2},
                                 {{kFeat, 1}, 4},
                                 {{kFeat, 2}, 5},
                                 {{kFeat, 3}, 5}});
}

TEST_CASE("the mask flavour's values lie where they are documented") {
  const PidLayout pid = layout_of({PidFlavour::mask});
  CHECK(place(pid.position[0]->value) == Place{16, 16, -32767, 32767});
  CHECK(place(pid.position[1]->value) == Place{32, 16, -32767, 32767});
  CHECK_FALSE(pid.position[2]);
  const PidSetEffect& effect = pid.set_effect;
  CHECK((effect.report.id == 0x10 && effect.report.size == 22));
  CHECK(place(effect.block) == Place{8, 8, 1, 40});
  CHECK(place(effect.constant) == std::pair(Place{16, 8, 1, 4}, std::int64_t{1}));
  CHECK(place(*effect.spring) == std::pair(Place{16, 8, 1, 4}, std::int64_t{3}));
  CHECK(place(*effect.duration) == Place{24, 16, 0, 32767});
  CHECK(place(*effect.trigger_repeat) == Place{40, 16, 0, 32767});
  CHECK(place(*effect.sample_period) == Place{56, 16, 0, 32767});
  CHECK(place(*effect.start_delay) == Place{72, 16, 0, 32767});
  CHECK(place(*effect.gain) == Place{88, 8, 0, 255});
  CHECK(place(*effect.trigger_button) == Place{96, 8, 1, 8});
  CHECK(place(*effect.axis_enable[0]) == Place{104, 1, 0, 1});
  CHECK(place(*effect.axis_enable[1]) == Place{105, 1, 0, 1});
  CHECK(place(*effect.direction_enable) == Place{106, 1, 0, 1});
  REQUIRE(effect.directions.size() == 2);
  CHECK(place(effect.directions[0]) == Place{112, 16, 0, 36'000});
  CHECK(place(effect.directions[1]) == Place{128, 16, 0, 36'000});
  CHECK(to_physical(effect.duration->field, 250) == 0.25);  // seconds
  CHECK(seconds_per_count(effect.duration->field) == 0.001);
  CHECK(to_physical(effect.directions[0].field, 9000) == 90);
  CHECK(place(pid.set_constant.magnitude) == Place{16, 16, -32767, 32767});
  const PidSetCondition& condition = *pid.set_condition;
  CHECK(place(*condition.parameter_block) == Place{16, 8, 0, 3});
  CHECK(place(*condition.center) == Place{24, 16, -32767, 32767});
  CHECK(place(condition.positive_coefficient) == Place{40, 16, -32767, 32767});
  CHECK(place(*condition.negative_coefficient) == Place{56, 16, -32767, 32767});
  CHECK(place(*condition.positive_saturation) == Place{72, 16, 0, 32767});
  CHECK(place(*condition.negative_saturation) == Place{88, 16, 0, 32767});
  CHECK(place(*condition.dead_band) == Place{104, 16, 0, 32767});
  // There is a bit for each command. The range is declared as 1 to 6, like that of the array from which the bits are made.
  const PidDeviceControl& control = *pid.device_control;
  CHECK(control.report.id == 0x18);
  CHECK(place(*control.enable_actuators) == std::pair(Place{8, 1, 1, 6}, std::int64_t{1}));
  CHECK(place(*control.reset) == std::pair(Place{11, 1, 1, 6}, std::int64_t{1}));
  CHECK(place(*control.resume) == std::pair(Place{13, 1, 1, 6}, std::int64_t{1}));
  CHECK((pid.create_effect->report.id == 0x20 && pid.block_load->report.id == 0x21 && pid.pool->report.id == 0x22));
  CHECK(place(*pid.create_effect->byte_count) == Place{16, 10, 0, 511});
  CHECK(place(pid.block_load->block) == Place{8, 8, 0, 40});
  CHECK(place(*pid.block_load->full) == std::pair(Place{16, 8, 1, 3}, std::int64_t{2}));
  CHECK(place(*pid.pool->simultaneous) == Place{24, 8, 0, 255});
  CHECK(place(*pid.pool->device_managed) == Place{32, 1, 0, 1});
  CHECK(place(*pid.state->effect_playing) == Place{12, 1, 0, 1});
  CHECK_FALSE(pid.state->block);
}

TEST_CASE("the array flavour differs where it is documented to") {
  const PidLayout pid = layout_of({PidFlavour::array});
  CHECK(place(pid.position[0]->value) == Place{16, 12, 0, 4095});
  CHECK(place(pid.position[1]->value) == Place{28, 12, 0, 4095});
  const PidSetEffect& effect = pid.set_effect;
  CHECK((effect.report.id == 1 && effect.report.size == 18));
  CHECK_FALSE(effect.start_delay);
  CHECK(place(*effect.gain) == Place{72, 8, 0, 255});
  CHECK(place(*effect.axis_enable[1]) == Place{89, 1, 0, 1});
  CHECK(place(effect.directions[0]) == Place{96, 8, 0, 255});
  CHECK(seconds_per_count(effect.duration->field) == 0.001);  // the exponent -3 is in a byte
  // This range is left over from the block index. Nothing may use it here.
  CHECK((effect.axis_enable[0]->field.physical_minimum == 1 && effect.axis_enable[0]->field.physical_maximum == 40));
  CHECK(place(pid.set_constant.magnitude) == Place{16, 16, -10'000, 10'000});
  const PidDeviceControl& control = *pid.device_control;
  CHECK(place(*control.enable_actuators) == std::pair(Place{8, 8, 1, 6}, std::int64_t{1}));
  CHECK(place(*control.disable_actuators) == std::pair(Place{8, 8, 1, 6}, std::int64_t{2}));
  CHECK(place(*control.resume) == std::pair(Place{8, 8, 1, 6}, std::int64_t{6}));
  // These reports have the same ids as output reports 1 to 3, but are others.
  CHECK((pid.create_effect->report.id == 1 && pid.block_load->report.id == 2 && pid.pool->report.id == 3));
  CHECK((pid.create_effect->report.size == 4 && pid.block_load->report.size == 5));
  CHECK(place(*pid.state->block) == Place{16, 8, 0, 40});
}

TEST_CASE("a duration is in its unit of time or in milliseconds where it has none") {
  FieldLayout duration;
  CHECK(seconds_per_count(duration) == 0.001);
  duration.unit_exponent = -6;  // an exponent without a unit
  CHECK(seconds_per_count(duration) == 0.001);
  for (const std::uint32_t unit : {0x1001u, 0x1003u}) {
    duration.unit = unit;
    duration.unit_exponent = 0;
    CHECK(seconds_per_count(duration) == 1);
    duration.unit_exponent = -3;
    CHECK(seconds_per_count(duration) == 0.001);
    duration.unit_exponent = -6;
    CHECK(seconds_per_count(duration) == Approx(1e-6));
    duration.unit_exponent = 1;
    CHECK(seconds_per_count(duration) == 10);
  }
}

TEST_CASE("arrays from a logical minimum of 0 that have one value more than usages count from 1") {
  for (const PidFlavour flavour : {PidFlavour::mask, PidFlavour::array}) {
    PidDescriptorOptions options{flavour};
    const PidLayout usual = layout_of(options);
    options.zero_is_none = true;
    const PidLayout pid = layout_of(options);
    CHECK((pid.set_effect.constant.value == 1 && pid.set_effect.spring->value == 3));
    CHECK((pid.operation.start.value == 1 && pid.operation.stop->value == 3));
    CHECK(pid.block_load->error->value == 3);
    CHECK(pid.device_control->reset->value == usual.device_control->reset->value);
  }
}

TEST_CASE("what a device leaves out is left out of its layout and nothing else") {
  for (const PidFlavour flavour : {PidFlavour::mask, PidFlavour::array}) {
    const auto without = [&](bool PidDescriptorOptions::*part) {
      PidDescriptorOptions options{flavour};
      options.*part = false;
      return layout_of(options);
    };
    using Options = PidDescriptorOptions;
    CHECK_FALSE(without(&Options::duration).set_effect.duration);
    CHECK(without(&Options::direction).set_effect.directions.empty());
    CHECK_FALSE(without(&Options::direction).set_effect.direction_enable);
    CHECK_FALSE(without(&Options::axes_enable).set_effect.axis_enable[0]);
    CHECK(without(&Options::axes_enable).set_effect.directions.size() == 2);
    CHECK_FALSE(without(&Options::effect_gain).set_effect.gain);
    CHECK_FALSE(without(&Options::conditions).set_condition);
    CHECK_FALSE(without(&Options::conditions).set_effect.spring);
    CHECK_FALSE(without(&Options::parameter_block).set_condition->parameter_block);
    CHECK_FALSE(without(&Options::center).set_condition->center);
    CHECK_FALSE(without(&Options::negative_coefficient).set_condition->negative_coefficient);
    CHECK_FALSE(without(&Options::saturation).set_condition->positive_saturation);
    CHECK_FALSE(without(&Options::negative_saturation).set_condition->negative_saturation);
    CHECK_FALSE(without(&Options::dead_band).set_condition->dead_band);
    CHECK_FALSE(without(&Options::device_control).device_control);
    CHECK_FALSE(without(&Options::device_gain).device_gain);
    CHECK_FALSE(without(&Options::block_free).block_free);
    CHECK_FALSE(without(&Options::stop_operation).operation.stop);
    CHECK_FALSE(without(&Options::pool).pool);
    CHECK_FALSE(without(&Options::state).state);
    CHECK_FALSE(without(&Options::block_load).create_effect);
    CHECK_FALSE(without(&Options::block_load).block_load);
  }
}

TEST_CASE("a device with one axis or three has those positions and enable bits") {
  for (int axes = 1; axes <= 3; ++axes) {
    for (const PidFlavour flavour : {PidFlavour::mask, PidFlavour::array}) {
      PidDescriptorOptions options{flavour};
      options.axes = axes;
      const PidLayout pid = layout_of(options);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(pid.position[axis].has_value() == (static_cast<int>(axis) < axes));
        CHECK(pid.set_effect.axis_enable[axis].has_value() == (static_cast<int>(axis) < axes));
      }
    }
  }
}

TEST_CASE("a descriptor without what a constant force needs says what is missing") {
  const auto missing_without = [](std::byte usage, std::byte instead) {
    std::vector<std::byte> bytes = pid_descriptor({PidFlavour::mask});
    for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
      if (bytes[i] == std::byte{0x09} && bytes[i + 1] == usage) bytes[i + 1] = instead;
    }
    const auto found = pid_layout(parsed_descriptor(bytes));
    REQUIRE_FALSE(found);
    std::string all;
    for (const std::string& one : found.error()) all += one + '\n';
    return all;
  };
  using Catch::Contains;
  CHECK_THAT(missing_without(std::byte{0x21}, std::byte{0xF0}), Contains("Set Effect output report (usage 0x0F0021)"));
  CHECK_THAT(missing_without(std::byte{0x73}, std::byte{0xF0}), Contains("Set Constant Force output report"));
  CHECK_THAT(missing_without(std::byte{0x77}, std::byte{0xF0}), Contains("Effect Operation output report"));
  CHECK_THAT(missing_without(std::byte{0x70}, std::byte{0xF0}), Contains("Magnitude (0x0F0070)"));
  CHECK_THAT(missing_without(std::byte{0x26}, std::byte{0xF0}), Contains("Constant Force (0x0F0026)"));
  CHECK_THAT(missing_without(std::byte{0x79}, std::byte{0xF0}), Contains("Start (0x0F0079)"));
  const std::string no_blocks = missing_without(std::byte{0x22}, std::byte{0xF0});
  CHECK_THAT(no_blocks,
             Contains("in Set Effect\n") && Contains("in Set Constant Force\n") && Contains("in Effect Operation\n"));
}

TEST_CASE("a magnitude that knows no sign is none") {
  std::vector<std::byte> bytes = pid_descriptor({PidFlavour::mask});
  // 16 01 80: logical minimum -32767.
  for (std::size_t i = 0; i + 2 < bytes.size(); ++i) {
    if (bytes[i] == std::byte{0x16} && bytes[i + 1] == std::byte{0x01} && bytes[i + 2] == std::byte{0x80})
      bytes[i + 1] = bytes[i + 2] = std::byte{0};
  }
  const auto found = pid_layout(parsed_descriptor(bytes));
  REQUIRE(found.error_or({}).size() == 1);
  CHECK_THAT(found.error().front(), Catch::Contains("both signs"));
}

TEST_CASE("what lies in another report of the same collection is not taken for a part of the first") {
  std::vector<std::byte> bytes = pid_descriptor({PidFlavour::mask});
  const std::array<std::byte, 4> direction{std::byte{0x09}, std::byte{0x57}, std::byte{0xA1}, std::byte{0x02}};
  const auto at = std::search(bytes.begin(), bytes.end(), direction.begin(), direction.end());
  REQUIRE(at != bytes.end());
  const std::array<std::byte, 2> report_id{std::byte{0x85}, std::byte{0x30}};
  bytes.insert(at, report_id.begin(), report_id.end());
  const auto found = pid_layout(parsed_descriptor(bytes));
  REQUIRE(found);
  CHECK(found->set_effect.report.id == 0x10);
  CHECK(found->set_effect.directions.empty());
  CHECK(found->set_effect.axis_enable[0]);
}
