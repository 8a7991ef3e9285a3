#pragma once
//
// A figure before and after.

namespace strak {

struct BeforeAfter {
  double before = 0, after = 0;
};

}  // namespace strak
