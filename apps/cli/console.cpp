#include "apps/cli/console.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

namespace strak::cli {

namespace {

// Characters of UTF-8 text: all bytes but the continuation bytes.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

void printError(const std::string& sentence) {
  // An error is one line, whatever a library put into its message.
  std::string line = sentence;
  std::replace(line.begin(), line.end(), '\n', ' ');
  fmt::print(stderr, "strak: {}\n", line);
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-"; }

std::string change(double before, double after) {
  if (!(before > 0) || !std::isfinite(after)) return "-";
  return fmt::format("{:+.2f} %", 100 * (after - before) / before);
}

std::string duration(double seconds) {
  if (seconds < 1) return fmt::format("{:.0f} ms", 1000 * seconds);
  if (seconds < 120) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.1f} min", seconds / 60);
}

Table::Table(std::vector<std::string> headings) : headings_(std::move(headings)) {
  for (auto& heading : headings_) {
    left_.push_back(heading.starts_with('<'));
    if (left_.back()) heading.erase(0, 1);
  }
}

void Table::add(std::vector<std::string> cells) {
  cells.resize(headings_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < headings_.size(); ++c) {
    widths.push_back(width(headings_[c]));
    for (const auto& row : rows_) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string out;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string padding(widths[c] - width(cells[c]), ' ');
      out += (c == 0 ? "" : "  ") + (left_[c] ? cells[c] + padding : padding + cells[c]);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + "\n";
  };
  line(headings_);
  for (const auto& row : rows_) line(row);
  return text;
}

ProgressBar::ProgressBar(std::vector<double> weights, bool wanted, std::function<bool()> stopped)
    : weights_(std::move(weights)),
      done_(weights_.size(), 0),
      visible_(wanted && ::isatty(STDERR_FILENO) != 0),
      stopped_(std::move(stopped)) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

Progress ProgressBar::task(std::size_t index) {
  return Progress([this, index](double fraction, std::string_view message) {
    if (visible_) {
      const std::lock_guard lock(mutex_);
      // A technique that does not know where it stands (a negative fraction) leaves the bar where it was.
      if (fraction >= 0) done_[index] = std::max(done_[index], std::min(fraction, 1.0));
      draw(message);
    }
    return !stopped_();
  });
}

void ProgressBar::draw(std::string_view message) {
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  const double whole = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  const double done = std::inner_product(weights_.begin(), weights_.end(), done_.begin(), 0.0);
  const double fraction = whole > 0 ? done / whole : 1;
  constexpr int kCells = 30;
  const int full = static_cast<int>(std::lround(fraction * kCells));
  fmt::print(stderr, "\r\033[K[{}{}] {:3.0f} %  {:.40}", std::string(static_cast<std::size_t>(full), '#'),
             std::string(static_cast<std::size_t>(kCells - full), '.'), 100 * fraction, message);
  std::fflush(stderr);
}

}  // namespace strak::cli
