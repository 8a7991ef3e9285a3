#pragma once
//
// Point fields on a box of control points, in the layout the solvers' inner loops want.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace strak {

// How the points of a box are laid out: axes (planes, rows, columns), the directions sorted by size, the shortest along
// the columns; missing directions have size 1. A row is the `components` coordinates of its points one after another,
// each padded with zeros to `stride` numbers, so that banded products need no edge cases.
struct BoxLayout {
  // `first` and `count`: the box inside a net of `sizes` points (1 to 3 directions); `halo`: zeros needed between rows.
  BoxLayout(const std::vector<Eigen::Index>& sizes, const std::vector<Eigen::Index>& first,
            const std::vector<Eigen::Index>& count, int components, int halo);

  int directions = 0;
  int components = 0;
  std::array<Eigen::Index, 3> size{1, 1, 1};      // planes, rows, columns
  std::array<int, 3> direction{-1, -1, -1};       // which direction runs along each axis; -1: none
  Eigen::Index width = 0;                         // columns rounded up to 8
  Eigen::Index stride = 0;                        // between the components of a row
  Eigen::Index lead = 0;                          // zeros before the first row
  std::array<Eigen::Index, 3> netFirst{0, 0, 0};  // along the axes
  std::array<Eigen::Index, 3> netStep{0, 0, 0};   // net rows from one index of an axis to the next

  Eigen::Index rows() const { return size[0] * size[1]; }
  Eigen::Index points() const { return rows() * size[2]; }
  Eigen::Index rowStride() const { return components * stride; }
  Eigen::Index planeStride() const { return size[1] * rowStride(); }
  Eigen::Index bufferSize() const { return 2 * lead + rows() * rowStride(); }
  // The net's row of the box's point (row, column).
  Eigen::Index netRow(Eigen::Index row, Eigen::Index column) const {
    return (netFirst[0] + row / size[1]) * netStep[0] + (netFirst[1] + row % size[1]) * netStep[1] +
           (netFirst[2] + column) * netStep[2];
  }
  // The layout of one number a point, without halo needs: the same box with one component.
  BoxLayout scalar() const;
};

// The numbers of a box, zero at first. Moves, does not copy by accident.
class Field {
 public:
  Field() = default;
  explicit Field(const BoxLayout& layout);

  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  Eigen::Index size() const { return size_; }
  // Component c of a row: `width` numbers with zeros on both sides.
  double* row(Eigen::Index r, int c) { return data_.get() + lead_ + r * rowStride_ + c * stride_; }
  const double* row(Eigen::Index r, int c) const { return data_.get() + lead_ + r * rowStride_ + c * stride_; }
  void setZero();

 private:
  struct Release {
    void operator()(double* p) const;
  };
  std::unique_ptr<double[], Release> data_;
  Eigen::Index size_ = 0, lead_ = 0, rowStride_ = 0, stride_ = 0;
};

using NetRef = Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
using MutableNetRef = Eigen::Ref<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

// Copies the box out of a net, minus `shift` (one number a component), and back: net += field on the box.
void packBox(const BoxLayout& layout, const NetRef& net, const Eigen::RowVectorXd& shift, Field& field);
void addBox(const BoxLayout& layout, const Field& field, MutableNetRef net);

// Vector operations on whole fields of one layout.
double dot(const Field& a, const Field& b);
void addScaled(Field& y, double factor, const Field& x);    // y += factor x
void scaleAndAdd(Field& y, double factor, const Field& x);  // y = factor y + x

}  // namespace strak
