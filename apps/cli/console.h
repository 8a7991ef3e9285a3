#pragma once
//
// What the program writes on the terminal: errors, tables, numbers for people, the progress bar.

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "strak/base/progress.h"

namespace strak::cli {

// "strak: sentence" on stderr.
void printError(const std::string& sentence);

// Wall-clock seconds since construction.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Four significant digits; "-" where there is no number.
std::string number(double value);
// "-42.9 %" for the change from `before` to `after`; "-" where it has no meaning.
std::string change(double before, double after);
std::string duration(double seconds);
// "3x3", "52x52".
template <class Numbers>
std::string times(const Numbers& numbers) {
  std::string text;
  for (auto n : numbers) text += (text.empty() ? "" : "x") + std::to_string(n);
  return text;
}

// Rows of text under headings, each column as wide as its widest cell. Columns align right unless their heading starts
// with '<'. Widths count characters, not bytes.
class Table {
 public:
  explicit Table(std::vector<std::string> headings);
  void add(std::vector<std::string> cells);
  bool empty() const { return rows_.empty(); }
  std::string text() const;

 private:
  std::vector<std::string> headings_;
  std::vector<bool> left_;
  std::vector<std::vector<std::string>> rows_;
};

// One bar for many tasks that run side by side. Draws on stderr, at most ten times a second, and only if stderr is a
// terminal and `wanted`; asks every task to stop once `stopped` says so.
class ProgressBar {
 public:
  // One task an entry of `weights`, its share of the whole work.
  ProgressBar(std::vector<double> weights, bool wanted, std::function<bool()> stopped);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // The progress of one task, to be handed to the library. The bar must outlive it.
  Progress task(std::size_t index);

 private:
  void draw(std::string_view message);

  std::vector<double> weights_, done_;
  bool visible_;
  bool drawn_ = false;
  std::function<bool()> stopped_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace strak::cli
