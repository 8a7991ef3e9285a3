#pragma once
//
// Writes SVG: numbers with two decimals, smooth lines as cubic Bezier paths, escaped text.

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace strak {

using PicturePolyline = std::vector<Eigen::Vector2d>;

// Text safe inside elements and quoted attributes of HTML, SVG and XML: & < > " ' are replaced, control characters and
// bytes that are no UTF-8 become the replacement character.
std::string escaped(std::string_view text);

// Path data of a smooth line through the points, at most 0.05 pixels from the polyline; corners of more than 30 degrees
// stay corners. Source: Schneider, "An algorithm for automatically fitting digitized curves", Graphics Gems (1990).
std::string smoothPath(const PicturePolyline& line);

// Path data of a closed polygon, accurate to a tenth of a pixel: points that are within 0.05 pixels of the line between
// their neighbours are left out, the others have one decimal.
std::string polygonPath(const PicturePolyline& polygon);

class SvgWriter {
 public:
  SvgWriter(int width, int height, std::string_view title);

  // `attributes` go into the element as they are: 'class="border"'. They must be free of text from outside.
  void path(std::string_view data, std::string_view attributes);
  void text(double x, double y, std::string_view text, std::string_view attributes);
  void rectangle(double x, double y, double width, double height, std::string_view attributes);
  void line(double x1, double y1, double x2, double y2, std::string_view attributes);
  void open(std::string_view attributes);  // a group
  void close();

  // The finished document, from <svg> to </svg>.
  std::string finish() &&;

 private:
  std::string out_;
};

// A number with at most `decimals` decimals, without trailing zeros and without a negative zero.
std::string shortNumber(double value, int decimals = 2);

// A number for people: `digits` significant digits, powers of ten only where they are shorter.
std::string figure(double value, int digits = 4);

}  // namespace strak
