// Delay against velocity jump, and against stiffness: where every choice lies, and the front.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "evenstep/reports/advice_record.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Box;
using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Stroke;
using internal::Svg;

constexpr double kWidth = 980, kHeight = 520;
constexpr Box kLeft{70, 50, 450, 420}, kRight{550, 50, 930, 420};
constexpr double kLegendRow = 490;

/// The log10; smaller values are shown at `least`.
double decade_of(double value, double least) { return std::log10(std::max(value, least)); }

/// A number of each choice; of jump and stiffness the log10.
using Number = double (*)(const AdviceChoice&);
double delay_s(const AdviceChoice& choice) { return choice.delay_s; }
double jump(const AdviceChoice& choice) { return decade_of(choice.jump_step, 1e-4); }
double stiffness(const AdviceChoice& choice) { return decade_of(choice.stiffness_N_per_m, 1e-3); }

double most(const std::vector<const AdviceChoice*>& choices, Number number) {
  double high = number(*choices.front());
  for (const AdviceChoice* choice : choices) high = std::max(high, number(*choice));
  return high;
}

/// Whole decades.
Range decades(const std::vector<const AdviceChoice*>& choices, Number number) {
  double low = number(*choices.front());
  for (const AdviceChoice* choice : choices) low = std::min(low, number(*choice));
  return {std::floor(low), std::max(std::ceil(most(choices, number) + 0.01), std::floor(low) + 1)};
}

/// The stairs below which (`up`: above which) none of these choices lies, up to the plot's edges.
void draw_front(Panel& panel, const Box& box, std::vector<const AdviceChoice*> choices, Number y, bool up,
                const Stroke& stroke, Svg& svg) {
  std::stable_sort(choices.begin(), choices.end(), [&](const AdviceChoice* a, const AdviceChoice* b) {
    const double sign = up ? -1 : 1;
    return std::pair(delay_s(*a), sign * y(*a)) < std::pair(delay_s(*b), sign * y(*b));
  });
  std::vector<Point> stairs;
  for (const AdviceChoice* choice : choices) {
    const Point at = panel.at(delay_s(*choice), y(*choice));
    if (stairs.empty())
      stairs.push_back({at.x, up ? box.bottom : box.top});
    else if (up ? at.y >= stairs.back().y : at.y <= stairs.back().y)
      continue;
    else
      stairs.push_back({at.x, stairs.back().y});
    stairs.push_back(at);
  }
  if (stairs.empty()) return;
  stairs.push_back({box.right, stairs.back().y});
  svg.polyline(stairs, stroke);
}

/// "6-15, 20, 21" of rising numbers.
std::string runs_of(const std::vector<int>& numbers) {
  std::string out;
  for (std::size_t from = 0, to = 0; from < numbers.size(); from = to) {
    while (to < numbers.size() && numbers[to] - numbers[from] == static_cast<int>(to - from)) ++to;
    if (to - from < 3) to = from + 1;
    out += fmt::format("{}{}", out.empty() ? "" : ", ", numbers[from]);
    if (to - from > 1) out += fmt::format("-{}", numbers[to - 1]);
  }
  return out;
}

/// The numbers of the choices beside their marks; those whose marks lie together share a label.
void draw_labels(Svg& svg, const Box& box, std::vector<std::pair<Point, int>> marks) {
  constexpr double kNearX = 18, kNearY = 9, kWideLabel = 110, kCharacter = 6.2, kLine = 11;  // px
  std::stable_sort(marks.begin(), marks.end(), [](const auto& a, const auto& b) { return a.first.x < b.first.x; });
  struct Label {
    Point from, to;
    std::vector<int> numbers;
  };
  std::vector<Label> labels;
  for (const auto& [at, number] : marks) {
    const auto near = std::find_if(labels.begin(), labels.end(), [&, place = at](const Label& label) {
      return place.x - label.to.x < kNearX && std::abs(place.y - label.from.y) < kNearY;
    });
    Label& label = near == labels.end() ? labels.emplace_back(Label{at, at, {}}) : *near;
    label.to = at;
    label.numbers.push_back(number);
  }
  std::vector<Box> written;
  for (Label& label : labels) {
    std::sort(label.numbers.begin(), label.numbers.end());
    const std::string text = runs_of(label.numbers);
    const bool at_edge = label.to.x + kWideLabel > box.right;
    const double wide = kCharacter * static_cast<double>(text.size());
    const double left = at_edge ? label.to.x + 6 - wide : label.from.x - 4;
    Box place{left, label.from.y - 9 - kLine, left + wide, label.from.y - 9};
    const auto meets = [&](const Box& other) {
      return place.left < other.right && other.left < place.right && place.top < other.bottom && other.top < place.bottom;
    };
    while (std::any_of(written.begin(), written.end(), meets)) {
      place.top -= kLine;
      place.bottom -= kLine;
    }
    written.push_back(place);
    svg.text({at_edge ? place.right : place.left, place.bottom}, text, at_edge ? Svg::Anchor::end : Svg::Anchor::start, 11);
  }
}

void draw(Svg& svg, const Box& box, const std::vector<const AdviceChoice*>& choices, Number y, bool up, Axis y_axis) {
  Panel panel(svg, box, Axis{{0, 1.08 * most(choices, delay_s)}, "delay, hand to force", "s"}, std::move(y_axis));
  panel.draw_axes(true, true);
  std::vector<const AdviceChoice*> as_it_is = choices;
  // `predict` extrapolates the hand's way and so has no delay: it would be the whole front.
  std::erase_if(as_it_is, [](const AdviceChoice* choice) { return choice->map == "predict"; });
  std::vector<const AdviceChoice*> changed = as_it_is;
  std::erase_if(as_it_is, [](const AdviceChoice* choice) { return !choice->governor.empty(); });
  if (as_it_is.size() < changed.size())
    draw_front(panel, box, changed, y, up, {internal::colour::kSkyBlue, 1.5, "6 4"}, svg);
  draw_front(panel, box, as_it_is, y, up, {internal::colour::kBlack, 1.5}, svg);
  std::vector<std::pair<Point, int>> marks;
  for (const AdviceChoice* choice : choices) {
    const Point at = panel.at(delay_s(*choice), y(*choice));
    if (choice->on_front)
      svg.dot(at, 5, internal::colour::kVermilion);
    else
      svg.square(at, 3.5, internal::colour::kGrey);
    marks.emplace_back(at, choice->number);
  }
  draw_labels(svg, box, std::move(marks));
}

}  // namespace

std::string advice_svg(const AdviceRecord& record) {
  std::vector<const AdviceChoice*> choices;
  for (const AdviceChoice& choice : record.choices) {
    if (choice.ranked) choices.push_back(&choice);
  }
  if (choices.empty()) return "";
  Svg svg(kWidth, kHeight, "What each choice costs: delay against velocity jump, and against stiffness");
  draw(svg, kLeft, choices, jump, false, Axis{decades(choices, jump), "velocity jump", "step", true});
  draw(svg, kRight, choices, stiffness, true, Axis{decades(choices, stiffness), "stiffness carried", "N/m", true});
  svg.dot({kLeft.left + 6, kLegendRow - 4}, 5, internal::colour::kVermilion);
  svg.text({kLeft.left + 18, kLegendRow}, "Pareto-optimal over all prices");
  svg.square({kLeft.left + 246, kLegendRow - 4}, 3.5, internal::colour::kGrey);
  svg.text({kLeft.left + 258, kLegendRow}, "beaten");
  const auto legend = [&](double x, const char* text, const Stroke& stroke) {
    svg.line({x, kLegendRow - 4}, {x + 24, kLegendRow - 4}, stroke);
    svg.text({x + 32, kLegendRow}, text);
  };
  legend(kRight.left - 160, "front of the two numbers, predict apart", {internal::colour::kBlack, 1.5});
  legend(kRight.left + 130, "if the simulator is changed as well", {internal::colour::kSkyBlue, 1.5, "6 4"});
  return std::move(svg).finish();
}

}  // namespace evenstep
