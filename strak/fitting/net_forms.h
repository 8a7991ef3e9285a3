#pragma once
//
// Linear forms in the coordinates of a net's control points, each near one place, that a quadratic problem of the net
// shall make zero: what couples the coordinates, as conditions on normals do.

#include "strak/solve/net_matrix.h"
#include "strak/spline/spline.h"

namespace strak {

// offset + sum over i, j of values(i, j) * direction . e(line + i, column + j), e the change of the net.
struct NetForm {
  Index line = 0, column = 0;  // the first control point
  Net values;
  Point direction;    // as many numbers as the net has coordinates
  double offset = 0;  // the value before the change
  double weight = 0;
};

double valueOf(const NetForm& form, const Net& change, Index columnsOfNet);

// sum over the coordinates of e^T A e + sum of weight * (form(e) + multiplier)^2 -> min: one sparse factor of all
// coordinates at once, whatever the number of forms.
class FormSystem {
 public:
  // `held`: control points that do not change. `matrix` must outlive the system.
  FormSystem(const NetMatrix& matrix, Index coordinates, const std::vector<Index>& held);

  // How much a form changes by its strongest control point alone, squared, for the cost of 1; the whole net can do
  // more.
  double strength(const NetForm& form) const;

  // False if the weights leave the factor no digits. Cost: one factor of 3 x 3 blocks for points in space.
  bool factor(const std::vector<NetForm>& forms);

  // The change of the net. `multipliers`: a number a form.
  Net solve(const std::vector<NetForm>& forms, const std::vector<double>& multipliers) const;

 private:
  const NetMatrix& matrix_;
  Index coordinates_;
  std::vector<char> held_;  // a coordinate each; empty: none
  NetCholesky solver_;
};

}  // namespace strak
