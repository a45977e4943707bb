#include "writers/figures/failure_marks.h"

namespace evenstep::internal {

const ExpectationResult* failed_on(std::span<const ExpectationResult> results, const std::string& device,
                                   const std::string& kind) {
  for (const ExpectationResult& result : results) {
    const bool here =
        result.signal.starts_with(device + '.' + kind + '.') || result.signal.starts_with(device + ".buffers.");
    if (here && result.first && result.worst) return &result;
  }
  return nullptr;
}

void draw_mark(Svg& svg, double x, const Box& box, double text_y, const std::string& text) {
  svg.line({x, box.top}, {x, box.bottom}, {colour::kPurple, 1.5, "7 4"});
  const bool on_the_left = x > (box.left + box.right) / 2;  // the side that has room for the text
  svg.text({x + (on_the_left ? -6 : 6), text_y}, text, on_the_left ? Svg::Anchor::end : Svg::Anchor::start, 12, true,
           colour::kPurple);
}

}  // namespace evenstep::internal
