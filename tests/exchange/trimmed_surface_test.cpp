// Trimmed faces written from nothing and read again.
#ifdef STRAK_HAS_CAD

#include "strak/exchange/trimmed_surface.h"

#include <cmath>

#include "strak/exchange/cad.h"
#include "strak/metrology/trim_region.h"
#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

// A wavy surface over [0, 2] x [0, 1], 200 x 100 units large.
Surface wave() {
  const KnotVector u = KnotVector::uniformClamped(3, 8, 0, 2), v = KnotVector::uniformClamped(3, 6, 0, 1);
  const auto x = u.greville(), y = v.greville();
  Net net(u.size() * v.size(), 3);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < y.size(); ++j) {
      net.row(static_cast<Index>(i * y.size() + j)) << 100 * x[i], 100 * y[j],
          10 * std::sin(3 * x[i]) * std::cos(2 * y[j]);
    }
  }
  return Surface({u, v}, std::move(net));
}

Curve line(double x0, double y0, double x1, double y1) {
  Net net(2, 2);
  net << x0, y0, x1, y1;
  return Curve({KnotVector::uniformClamped(1, 1)}, std::move(net));
}

// Clockwise, as a hole must run: the surface is seen to the left.
TrimLoop roundHole(double x, double y, double radius) {
  constexpr int kCorners = 16;
  Net net(kCorners + 2, 2);
  for (Index i = 0; i < net.rows(); ++i) {
    const double angle = -2 * 3.14159265358979 * static_cast<double>(i % kCorners) / kCorners;
    net.row(i) << x + radius * std::cos(angle), y + radius * std::sin(angle);
  }
  const Net middle = (net.row(0) + net.row(1)) / 2;
  net.row(0) = net.row(net.rows() - 1) = middle;
  return {Curve({KnotVector::uniformClamped(2, kCorners)}, std::move(net))};
}

TrimmedPart withHoles() {
  TrimmedPart part;
  part.outer = {line(0.1, 0.1, 1.9, 0.15), line(1.9, 0.15, 1.8, 0.9), line(1.8, 0.9, 0.1, 0.9),
                line(0.1, 0.9, 0.1, 0.1)};
  part.holes = {
      roundHole(0.6, 0.5, 0.2),
      {line(1.2, 0.4, 1.2, 0.6), line(1.2, 0.6, 1.5, 0.6), line(1.5, 0.6, 1.5, 0.4), line(1.5, 0.4, 1.2, 0.4)}};
  return part;
}

class TrimmedSurface : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { enableCad(); }
  Folder folder_;
};

TEST_P(TrimmedSurface, ComesBackValidWithItsHoles) {
  const auto path = folder_ / (std::string("out.") + GetParam());
  const Surface surface = wave();
  writeTrimmed(path, surface, {withHoles()}, "sheet");
  const auto model = readModel(path);
  ASSERT_EQ(model->objects().size(), 1U);
  const Object& face = model->objects()[0];
  ASSERT_TRUE(face.spline.has_value());
  EXPECT_EQ(std::get<Surface>(*face.spline).knots(), surface.knots());
  EXPECT_EQ(face.trims.size(), 9U);
  const Audit audit = model->audit();
  EXPECT_TRUE(audit.valid);
  EXPECT_LT(audit.largestGap, 1e-6);
  EXPECT_LT(audit.largestTolerance, 1e-5);

  const TrimRegion region(surface, face.trims);
  for (const auto& [u, v, seen] : {std::tuple{0.2, 0.5, true},
                                   {0.6, 0.5, false},
                                   {0.6, 0.75, true},
                                   {1.3, 0.5, false},
                                   {1.6, 0.5, true},
                                   {0.05, 0.5, false},
                                   {1.9, 0.95, false}}) {
    EXPECT_EQ(region.inside({u, v}), seen) << u << ", " << v;
  }
}

TEST_P(TrimmedSurface, TwoPartsAreTwoFacesOfOneSurface) {
  const auto path = folder_ / (std::string("out.") + GetParam());
  TrimmedPart left, right;
  left.outer = {line(0, 0, 0.8, 0), line(0.8, 0, 0.8, 1), line(0.8, 1, 0, 1), line(0, 1, 0, 0)};
  right.outer = {line(1, 0, 2, 0), line(2, 0, 2, 1), line(2, 1, 1, 1), line(1, 1, 1, 0)};
  writeTrimmed(path, wave(), {left, right}, "sheet");
  const auto model = readModel(path);
  EXPECT_EQ(model->objects().size(), 2U);
  EXPECT_TRUE(model->audit().valid);
}

INSTANTIATE_TEST_SUITE_P(Formats, TrimmedSurface, testing::Values("step", "igs", "brep"));

TEST(TrimmedSurfaceRefuses, WhatCannotBeWritten) {
  enableCad();
  const Folder folder;
  const TrimmedPart good = withHoles();
  EXPECT_FALSE(holdsTrimming("a.g2"));
  EXPECT_TRUE(holdsTrimming("a.IGES"));
  EXPECT_NE(refusal([&] { writeTrimmed(folder / "a.g2", wave(), {good}, "a"); }).find("no trimming"),
            std::string::npos);
  TrimmedPart open = good;
  open.outer.pop_back();
  EXPECT_NE(refusal([&] { writeTrimmed(folder / "a.step", wave(), {open}, "a"); }).find("open"), std::string::npos);
  TrimmedPart beyond = good;
  beyond.holes.push_back(roundHole(0.1, 0.5, 0.2));
  EXPECT_NE(refusal([&] { writeTrimmed(folder / "a.step", wave(), {beyond}, "a"); }).find("outside"),
            std::string::npos);
  TrimmedPart empty;
  EXPECT_NE(refusal([&] { writeTrimmed(folder / "a.step", wave(), {empty}, "a"); }), "");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.step"));
}

}  // namespace
}  // namespace strak

#endif
