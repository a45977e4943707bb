#include "writers/figures/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "writers/texts/text.h"

namespace evenstep::internal {
namespace {

std::string stroke_text(const Stroke& stroke) {
  std::string text = fmt::format("stroke=\"{}\" stroke-width=\"{:g}\"", stroke.colour, stroke.width);
  if (*stroke.dash) text += fmt::format(" stroke-dasharray=\"{}\"", stroke.dash);
  if (stroke.opacity != 1) text += fmt::format(" opacity=\"{:g}\"", stroke.opacity);
  return text;
}

double tick_step(Range range, int wanted) {
  const double raw = (range.high - range.low) / wanted;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  const double share = raw / power;
  return power * (share < 1.5 ? 1 : share < 3.5 ? 2 : share < 7.5 ? 5 : 10);
}

/// The text of a tick, with as many decimals as the step between ticks has; scientific notation for tiny or huge steps.
std::string tick_text(double value, double step) {
  if (std::abs(value) < step * 1e-6) return "0";
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step * 1.000001))));
  if (decimals > 4 || step >= 1e5) return fmt::format("{:.3g}", value);
  return fmt::format("{:.{}f}", value, decimals);
}

/// "10⁻⁶"
std::string power_of_ten(double exponent) {
  constexpr std::array kDigits = std::to_array<const char*>({"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"});
  std::string text = "10";
  for (const char c : fmt::format("{:.0f}", exponent)) text += c == '-' ? "⁻" : kDigits[static_cast<std::size_t>(c - '0')];
  return text;
}

bool finite(Point p) { return std::isfinite(p.x) && std::isfinite(p.y); }

/// The points of one pixel column: the first, the least, the greatest and the last, in their order.
void put_column(std::vector<Point>& out, const std::vector<Point>& column) {
  if (column.size() <= 4) return void(out.insert(out.end(), column.begin(), column.end()));
  const auto [least, most] = std::minmax_element(column.begin(), column.end(), [](Point a, Point b) { return a.y < b.y; });
  std::vector<std::vector<Point>::const_iterator> kept{column.begin(), least, most, std::prev(column.end())};
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  for (const auto point : kept) out.push_back(*point);
}

std::vector<Point> decimated(const std::vector<Point>& points) {
  std::vector<Point> out, column;
  for (const Point& point : points) {
    if (!column.empty() && std::floor(point.x) != std::floor(column.front().x)) {
      put_column(out, column);
      column.clear();
    }
    column.push_back(point);
  }
  put_column(out, column);
  return out;
}

}  // namespace

Range Range::around(const std::vector<double>& values, double margin) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (!(low <= high)) return {-1, 1};
  // With a span below the rounding of its values, all ticks would show the same number.
  const double least = std::max({std::abs(low), std::abs(high)}) * 1e-9;
  const double span = high - low > least ? high - low : low == 0 && high == 0 ? 2 : std::max(std::abs(high), least) * 0.2;
  const double middle = (low + high) / 2, half = span * (0.5 + margin);
  return {middle - half, middle + half};
}

Svg::Svg(double width, double height, std::string_view title) : width_(width) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}\" height=\"{1:g}\" viewBox=\"0 0 {0:g} {1:g}\" "
      "font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" role=\"img\">\n<title>{2}</title>\n"
      "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"#ffffff\"/>\n",
      width, height, xml_escape(title));
  text({width_ / 2, 22}, title, Anchor::middle, 15, true);
}

void Svg::line(Point from, Point to, const Stroke& stroke) {
  out_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>\n", from.x, from.y, to.x, to.y,
                      stroke_text(stroke));
}

void Svg::polyline(const std::vector<Point>& points, const Stroke& stroke) {
  if (points.size() < 2) return;
  out_ += fmt::format("<polyline fill=\"none\" stroke-linejoin=\"round\" {} points=\"", stroke_text(stroke));
  for (const Point& p : points) fmt::format_to(std::back_inserter(out_), "{:.2f},{:.2f} ", p.x, p.y);
  out_.back() = '"';
  out_ += "/>\n";
}

void Svg::rect(const Box& box, const char* fill, const char* outline) {
  out_ += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\" stroke=\"{}\"/>\n",
                      box.left, box.top, box.right - box.left, box.bottom - box.top, fill, outline);
}

void Svg::dot(Point centre, double radius, const char* fill) {
  out_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:g}\" fill=\"{}\"/>\n", centre.x, centre.y, radius, fill);
}

void Svg::square(Point centre, double half, const char* fill) {
  rect({centre.x - half, centre.y - half, centre.x + half, centre.y + half}, fill, "#ffffff");
}

void Svg::text(Point at, std::string_view text, Anchor anchor, double size_px, bool bold, const char* fill) {
  const char* name = anchor == Anchor::start ? "start" : anchor == Anchor::middle ? "middle" : "end";
  out_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" text-anchor=\"{}\"{}{}>{}</text>\n", at.x, at.y,
                      size_px, name, bold ? " font-weight=\"bold\"" : "",
                      fill == std::string_view(colour::kBlack) ? "" : fmt::format(" fill=\"{}\"", fill), xml_escape(text));
}

void Svg::text_upwards(Point at, std::string_view text) {
  out_ += fmt::format(
      "<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" font-size=\"12\" text-anchor=\"middle\">{}</text>\n", at.x,
      at.y, xml_escape(text));
}

std::string Svg::finish() && { return std::move(out_) + "</svg>\n"; }

std::vector<double> round_ticks(Range range, int wanted) {
  std::vector<double> ticks;
  const double step = tick_step(range, wanted);
  const double first = std::ceil(range.low / step - 1e-9);
  for (double k = first; k * step <= range.high + step * 1e-9; ++k) ticks.push_back(k * step);
  return ticks;
}

double Axis::factor() const {
  if (decades || (unit != "m" && unit != "s" && unit != "N")) return 1;
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  return size >= 0.5 ? 1 : size >= 0.5e-3 ? 1e-3 : size >= 0.5e-6 ? 1e-6 : 1e-9;
}

std::string Axis::label() const {
  const double f = factor();
  const char* prefix = f == 1 ? "" : f == 1e-3 ? "m" : f == 1e-6 ? "µ" : "n";
  return fmt::format("{} [{}{}]", name, prefix, unit);
}

double Panel::x_at(double x) const {
  return box_.left + (x - x_.range.low) / (x_.range.high - x_.range.low) * (box_.right - box_.left);
}
double Panel::y_at(double y) const {
  return box_.bottom - (y - y_.range.low) / (y_.range.high - y_.range.low) * (box_.bottom - box_.top);
}

void Panel::draw_y() {
  const double f = y_.factor();
  const Range shown{y_.range.low / f, y_.range.high / f};
  const int wanted = std::max(2, static_cast<int>((box_.bottom - box_.top) / (y_.decades ? 24 : 40)));
  const double step = tick_step(shown, wanted);
  for (const double tick : round_ticks(shown, wanted)) {
    if (y_.decades && tick != std::round(tick)) continue;
    const double y = y_at(tick * f);
    svg_.line({box_.left, y}, {box_.right, y}, {colour::kGrid, 1});
    svg_.text({box_.left - 6, y + 4}, y_.decades ? power_of_ten(tick) : tick_text(tick, step), Svg::Anchor::end, 11);
  }
  svg_.text_upwards({box_.left - 56, (box_.top + box_.bottom) / 2}, y_.label());
}

void Panel::draw_x(bool numbers, bool label) {
  const double f = x_.factor();
  const Range shown{x_.range.low / f, x_.range.high / f};
  const int wanted = std::max(2, static_cast<int>((box_.right - box_.left) / 90));
  const double step = tick_step(shown, wanted);
  for (const double tick : round_ticks(shown, wanted)) {
    if (x_.decades && tick != std::round(tick)) continue;
    const double x = x_at(tick * f);
    svg_.line({x, box_.top}, {x, box_.bottom}, {colour::kGrid, 1});
    if (!numbers) continue;
    svg_.text({x, box_.bottom + 16}, x_.decades ? power_of_ten(tick) : tick_text(tick, step), Svg::Anchor::middle, 11);
  }
  if (label) svg_.text({(box_.left + box_.right) / 2, box_.bottom + 35}, x_.label(), Svg::Anchor::middle);
}

void Panel::draw_axes(bool x_numbers, bool x_label) {
  draw_y();
  draw_x(x_numbers, x_label);
  svg_.rect(box_, "none", colour::kGrey);
}

void Panel::curve(const std::vector<double>& x, const std::vector<double>& y, const Stroke& stroke) {
  std::vector<Point> piece;
  for (std::size_t i = 0; i <= x.size(); ++i) {
    const Point point = i < x.size() ? at(x[i], y[i]) : Point{NAN, NAN};
    if (finite(point)) {
      piece.push_back(point);
    } else {
      svg_.polyline(decimated(piece), stroke);
      piece.clear();
    }
  }
}

}  // namespace evenstep::internal
