#include "evenstep/device/hid/pid_descriptors.h"

#include <cassert>
#include <initializer_list>
#include <utility>

#include "descriptor_items.h"

namespace evenstep {
namespace {

using internal::Items;

constexpr int kData = 0x00, kConst = 0x01, kVariable = 0x02;
constexpr int kMaxEffects = 40;

/// The ids of the reports. The array flavour uses the same number for an output report and a feature report.
struct Ids {
  int position, state, set_effect, set_condition, set_constant, operation, block_free, control, gain, create, load, pool;
};
constexpr Ids kMaskIds{0x01, 0x02, 0x10, 0x12, 0x14, 0x16, 0x17, 0x18, 0x19, 0x20, 0x21, 0x22};
constexpr Ids kArrayIds{1, 2, 1, 2, 3, 4, 5, 6, 7, 1, 2, 3};

class Author {
 public:
  explicit Author(const PidDescriptorOptions& options)
      : options_(options), mask_(options.flavour == PidFlavour::mask), ids_(mask_ ? kMaskIds : kArrayIds) {}

  std::vector<std::byte> write() {
    at_.page(0x01);
    at_.usage(0x04);  // Joystick
    at_.item(0xA0, 1);
    position();
    at_.page(0x0F);
    if (options_.state) state();
    set_effect();
    if (options_.conditions) set_condition();
    set_constant();
    operation();
    if (options_.block_free) block_only(0x90, ids_.block_free);
    if (options_.device_control) device_control();
    if (options_.device_gain) device_gain();
    if (options_.block_load) {
      create_effect();
      block_load();
    }
    if (options_.pool) pool();
    at_.close();
    return std::move(at_.bytes);
  }

 private:
  int magnitude() const { return mask_ ? 32767 : 10'000; }

  void position() {
    at_.item(0x84, ids_.position);
    at_.item(0xA4, 0, 0);  // Push: the Pop undoes the page and sizes of the buttons
    at_.page(0x09);
    at_.item(0x18, 1);
    at_.item(0x28, 8);
    at_.logical(0, 1);
    at_.format(1, 8);
    at_.input(kVariable);
    at_.item(0xB4, 0, 0);
    mask_ ? at_.logical(-32767, 32767) : at_.logical(0, 4095);
    at_.format(mask_ ? 16 : 12, options_.axes);
    at_.item(0x18, 0x30);
    at_.item(0x28, 0x30 + options_.axes - 1);
    at_.input(kVariable);
    if (!mask_ && options_.axes % 2 == 1) input_padding(4);
  }
  void input_padding(int bits) {
    at_.format(bits, 1);
    at_.input(kConst | kVariable);
  }

  void state() {
    at_.open_report(0x92, ids_.state);
    at_.logical(0, 1);
    at_.format(1, 5);
    at_.usages({0x9F, 0xA0, 0xA4, 0xA6, 0x94});
    at_.input(kVariable);
    input_padding(3);
    if (!mask_) {
      at_.logical(0, kMaxEffects);
      at_.format(8, 1);
      at_.usage(0x22);
      at_.input(kVariable);
    }
    at_.close();
  }

  void block() {
    at_.logical(1, kMaxEffects);
    at_.physical(1, kMaxEffects);
    at_.format(8, 1);
    // The array flavour writes the usage in four bytes, with its page.
    mask_ ? at_.usage(0x22) : at_.item(0x08, 0x0F0022, 4);
    at_.output(kVariable);
  }
  void block_only(int usage, int id) {
    at_.open_report(usage, id);
    block();
    at_.close();
  }
  void array_range(int count) { at_.logical(options_.zero_is_none ? 0 : 1, count); }
  void effect_types() {
    at_.open(0x25);
    options_.conditions ? at_.usages({0x26, 0x31, 0x40, 0x41}) : at_.usages({0x26, 0x31});
    array_range(options_.conditions ? 4 : 2);
    at_.format(8, 1);
  }
  /// The array flavour sets no physical range here, so the block index's range stays in force.
  void plain_physical() {
    if (mask_) at_.physical(0, 0);
  }

  void set_effect() {
    at_.open_report(0x21, ids_.set_effect);
    block();
    effect_types();
    at_.output(kData);
    at_.close();
    times();
    if (options_.effect_gain) {
      at_.logical(0, 255);
      if (mask_) at_.physical(0, 10'000);
      at_.format(8, 1);
      at_.usage(0x52);
      at_.output(kVariable);
    }
    trigger_button();
    axes_enable();
    if (options_.direction) directions();
    plain_physical();
    at_.open(0x58);  // Type Specific Block Offset
    at_.page(0x0A);
    at_.usages({1, 2});
    at_.page(0x0F);
    at_.logical(0, 32'767);
    at_.format(16, 2);
    at_.output(kVariable);
    at_.close();
    at_.close();
  }

  /// Milliseconds. The mask flavour writes the exponent -3 in a nibble, the other one in a byte.
  void times() {
    at_.logical(0, 32'767);
    if (mask_) at_.physical(0, 32'767);
    at_.unit(mask_ ? 0x1001 : 0x1003, mask_ ? 0x0D : 0xFD);
    if (options_.duration) {
      at_.format(16, mask_ ? 4 : 3);
      mask_ ? at_.usages({0x50, 0x54, 0x51, 0xA7}) : at_.usages({0x50, 0x54, 0x51});
      at_.output(kVariable);
    }
    at_.unit(0, 0);
  }

  void trigger_button() {
    at_.logical(1, 8);
    if (mask_) at_.physical(1, 8);
    at_.format(8, 1);
    at_.usage(0x53);
    at_.output(kVariable);
  }

  void axes_enable() {
    at_.logical(0, 1);
    plain_physical();
    at_.format(1, options_.axes);
    if (options_.axes_enable) {
      at_.open(0x55);
      at_.page(0x01);
      at_.item(0x18, 0x30);
      at_.item(0x28, 0x30 + options_.axes - 1);
      at_.output(kVariable);
      at_.close();
      at_.page(0x0F);
    } else {
      at_.output(kConst | kVariable);
    }
    at_.format(1, 1);
    if (options_.direction) at_.usage(0x56);
    at_.output(options_.direction ? kVariable : kConst | kVariable);
    at_.format(7 - options_.axes, 1);
    at_.output(kConst | kVariable);
  }

  void directions() {
    at_.open(0x57);
    mask_ ? at_.logical(0, 36'000) : at_.logical(0, 255);
    if (mask_) {
      at_.physical(0, 36'000);
      at_.unit(0x14, 0x0E);  // degrees, 10^-2
    }
    at_.format(mask_ ? 16 : 8, 2);
    at_.item(0x08, 0x0A0001, 4);
    at_.item(0x08, 0x0A0002, 4);
    at_.output(kVariable);
    at_.unit(0, 0);
    at_.close();
  }

  void condition_values(std::int64_t minimum, std::int64_t maximum, std::initializer_list<int> usages) {
    at_.logical(minimum, maximum);
    at_.format(16, static_cast<int>(usages.size()));
    at_.usages(usages);
    at_.output(kVariable);
  }
  void set_condition() {
    at_.open_report(0x5F, ids_.set_condition);
    block();
    plain_physical();
    at_.logical(0, 3);
    at_.format(8, 1);
    if (options_.parameter_block) at_.usage(0x23);
    at_.output(options_.parameter_block ? kVariable : kConst | kVariable);
    if (options_.center) condition_values(-magnitude(), magnitude(), {0x60});
    condition_values(-magnitude(), magnitude(), {0x61});
    if (options_.negative_coefficient) condition_values(-magnitude(), magnitude(), {0x62});
    if (options_.saturation) condition_values(0, magnitude(), {0x63});
    if (options_.saturation && options_.negative_saturation) condition_values(0, magnitude(), {0x64});
    if (options_.dead_band) condition_values(0, magnitude(), {0x65});
    at_.close();
  }

  void set_constant() {
    at_.open_report(0x73, ids_.set_constant);
    block();
    plain_physical();
    at_.logical(-magnitude(), magnitude());
    at_.format(16, 1);
    at_.usage(0x70);
    at_.output(kVariable);
    at_.close();
  }

  void operation() {
    at_.open_report(0x77, ids_.operation);
    block();
    plain_physical();
    at_.open(0x78);
    options_.stop_operation ? at_.usages({0x79, 0x7A, 0x7B}) : at_.usages({0x79, 0x7A});
    array_range(options_.stop_operation ? 3 : 2);
    at_.format(8, 1);
    at_.output(kData);
    at_.close();
    at_.logical(0, 255);
    at_.usage(0x7C);
    at_.output(kVariable);
    at_.close();
  }

  void device_control() {
    // Devices also differ in the usage of this collection. The mask has fewer usages than bits; the last usage is repeated.
    at_.open_report(mask_ ? 0x96 : 0x95, ids_.control);
    if (!mask_) at_.open(0x96);
    at_.usages({0x97, 0x98, 0x99, 0x9A, 0x9B, 0x9C});
    array_range(6);
    mask_ ? at_.format(1, 8) : at_.format(8, 1);
    at_.output(mask_ ? kVariable : kData);
    if (!mask_) at_.close();
    at_.close();
  }

  void device_gain() {
    at_.open_report(0x7D, ids_.gain);
    at_.logical(0, 255);
    if (mask_) at_.physical(0, 10'000);
    at_.format(8, 1);
    at_.usage(0x7E);
    at_.output(kVariable);
    at_.close();
  }

  void create_effect() {
    at_.open_report(0xAB, ids_.create);
    effect_types();
    at_.feature(kData);
    at_.close();
    at_.page(0x01);
    at_.usage(0x3B);  // Byte Count
    at_.logical(0, 511);
    at_.format(10, 1);
    at_.feature(kVariable);
    at_.page(0x0F);
    at_.format(6, 1);
    at_.feature(kConst | kVariable);
    at_.close();
  }

  void block_load() {
    at_.open_report(0x89, ids_.load);
    at_.logical(0, kMaxEffects);
    at_.format(8, 1);
    at_.usage(0x22);
    at_.feature(kVariable);
    at_.open(0x8B);
    at_.usages({0x8C, 0x8D, 0x8E});
    array_range(3);
    at_.feature(kData);
    at_.close();
    at_.logical(0, 65'535);
    at_.format(16, 1);
    at_.usage(0xAC);
    at_.feature(kVariable);
    at_.close();
  }

  void pool() {
    at_.open_report(0x7F, ids_.pool);
    at_.logical(0, 65'535);
    at_.format(16, 1);
    at_.usage(0x80);
    at_.feature(kVariable);
    at_.logical(0, 255);
    at_.format(8, 1);
    at_.usage(0x83);
    at_.feature(kVariable);
    at_.logical(0, 1);
    at_.format(1, 2);
    at_.usages({0xA9, 0xAA});
    at_.feature(kVariable);
    at_.format(6, 1);
    at_.feature(kConst | kVariable);
    at_.close();
  }

  PidDescriptorOptions options_;
  bool mask_;
  Ids ids_;
  Items at_;
};

}  // namespace

std::vector<std::byte> pid_descriptor(const PidDescriptorOptions& options) {
  assert(options.axes >= 1 && options.axes <= 3);
  return Author(options).write();
}

}  // namespace evenstep
