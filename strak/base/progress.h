#pragma once
//
// How long work tells its caller where it stands, and how the caller asks it to stop.

#include <functional>
#include <string_view>
#include <utility>

namespace strak {

// A callback handle, cheap to copy; a default-constructed one reports to nobody and never cancels.
class Progress {
 public:
  // `fraction` in [0, 1] (or negative where unknown), `message` in a few words. Returns false to ask for an early stop.
  using Callback = std::function<bool(double fraction, std::string_view message)>;

  Progress() = default;
  explicit Progress(Callback callback) : callback_(std::move(callback)) {}

  // Reports; returns true if the work should go on. A stopped technique returns the best result it has, marked as such.
  bool report(double fraction, std::string_view message) const { return !callback_ || callback_(fraction, message); }

 private:
  Callback callback_;
};

}  // namespace strak
