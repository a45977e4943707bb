#pragma once
/// Just enough SVG for the figures: shapes, text, and a panel with axes in SI units and round ticks. The colours are those
/// of Okabe and Ito, which colour-blind readers can tell apart; curves also differ in their dashes.

#include <string>
#include <string_view>
#include <vector>

namespace evenstep::internal {

namespace colour {
inline constexpr const char* kBlack = "#000000";
inline constexpr const char* kGrey = "#767676";
inline constexpr const char* kGrid = "#dddddd";
inline constexpr const char* kOrange = "#e69f00";
inline constexpr const char* kSkyBlue = "#56b4e9";
inline constexpr const char* kGreen = "#009e73";
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kVermilion = "#d55e00";
inline constexpr const char* kPurple = "#cc79a7";
}  // namespace colour

struct Point {
  double x = 0, y = 0;
};
struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;
};
struct Range {
  double low = 0, high = 1;
  /// The range of the finite values in a list, plus a share of the span on both sides; [-1, 1] for a single value of 0.
  static Range around(const std::vector<double>& values, double margin = 0.05);
};
struct Stroke {
  const char* colour = colour::kBlack;
  double width = 1.5;
  const char* dash = "";  ///< stroke-dasharray
  double opacity = 1;
};

class Svg {
 public:
  Svg(double width, double height, std::string_view title);
  void line(Point from, Point to, const Stroke& stroke);
  void polyline(const std::vector<Point>& points, const Stroke& stroke);
  void rect(const Box& box, const char* fill, const char* outline);
  void dot(Point centre, double radius, const char* fill);
  void square(Point centre, double half, const char* fill);
  enum class Anchor { start, middle, end };
  void text(Point at, std::string_view text, Anchor anchor = Anchor::start, double size_px = 12, bool bold = false,
            const char* fill = colour::kBlack);
  void text_upwards(Point at, std::string_view text);
  std::string finish() &&;

 private:
  double width_;
  std::string out_;
};

/// Round tick values (1, 2 or 5 times a power of ten) inside the range, about `wanted` of them.
std::vector<double> round_ticks(Range range, int wanted);

/// An axis. Values are divided by 10^(3 * power), and the unit gets the prefix for it, e.g. 0.012 m is 12 mm.
struct Axis {
  Range range;
  std::string name;      ///< "position"
  std::string unit;      ///< "m"; prefixes only for m, s and N
  bool decades = false;  ///< values and range are log10 of the numbers that are shown; no prefix
  double factor() const;
  std::string label() const;  ///< "position [mm]"
};

/// A rectangle in the picture with two axes.
class Panel {
 public:
  Panel(Svg& svg, Box box, Axis x, Axis y) : svg_(svg), box_(box), x_(std::move(x)), y_(std::move(y)) {}
  /// Draws grid, frame and tick labels; the label of x only if asked for.
  void draw_axes(bool x_numbers, bool x_label);
  /// Draws a curve. Points that are not finite interrupt it. At most four points (first, least, greatest, last) are kept per
  /// pixel column.
  void curve(const std::vector<double>& x, const std::vector<double>& y, const Stroke& stroke);
  Point at(double x, double y) const { return {x_at(x), y_at(y)}; }
  double x_at(double x) const;
  double y_at(double y) const;

 private:
  void draw_y();
  void draw_x(bool numbers, bool label);
  Svg& svg_;
  Box box_;
  Axis x_, y_;
};

}  // namespace evenstep::internal
