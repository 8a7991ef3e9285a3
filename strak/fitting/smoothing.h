#pragma once
//
// How much a fit is smoothed: the weight lambda of the energy in
//   mean of w |z - X(u)|^2  +  lambda * E(X),
// given, or chosen by generalised cross validation, by restricted maximum likelihood or from the known noise.
//
// Source: Craven and Wahba, "Smoothing noisy data with spline functions" (1979); Morozov's discrepancy principle. The
// trace of the influence matrix, the fit's degrees of freedom, is exact up to interpolation: with M = A + lambda K,
// tr(A M^-1) = n - d log det M / d log lambda, and a Cholesky factor gives log det M for nothing. So does it the
// likelihood of the errors once what the energy does not see is taken out: with q free control points, m dimensions
// that the energy does not see and N points, -2 log L is but for constants
//   (N - m) log(mean square + lambda E) + log det M - (q - m) log lambda
// a coordinate (Wahba, "A comparison of GCV and GML", 1985; Wood, "Fast stable REML", 2011). It trusts that the errors
// are normal and independent, and then varies less than cross validation does.

#include <vector>

#include "strak/solve/net_matrix.h"

namespace strak {

struct Smoothing {
  enum class Choice { fixed, crossValidation, restrictedLikelihood, noise };
  Choice choice = Choice::crossValidation;
  double value = 0;  // lambda, or the standard deviation of each coordinate's noise, which the errors are to have

  static Smoothing automatic() { return {}; }
  static Smoothing likeliest() { return {Choice::restrictedLikelihood, 0}; }
  static Smoothing fixed(double lambda) { return {Choice::fixed, lambda}; }
  static Smoothing noise(double deviation) { return {Choice::noise, deviation}; }
};

// The least squares problem in a correction e of a net d0 whose errors are known:
//   meanSquare - 2 e . right + e . data e + lambda (d0 + e) . energy (d0 + e)  -> min.
// Measured from a good d0 the sum of squares loses nothing to cancellation.
struct SmoothingProblem {
  NetMatrix data;          // mean of w B B^T
  NetMatrix energy;        // K
  NetVectors reference;    // d0, a row a control point
  NetVectors right;        // mean of w B (error of d0)^T
  double meanSquare = 0;   // of the errors of d0
  double points = 0;       // how many there are
  std::vector<char> held;  // control points that stay as in d0; empty: none
};

struct Smoothed {
  double lambda = 0;
  NetVectors net;              // d0 + e
  double meanSquare = 0;       // of the errors
  double energy = 0;           // without lambda
  double freedom = 0;          // tr(A (A + lambda K)^-1): how many parameters the fit has, in effect
  double crossValidation = 0;  // meanSquare / (1 - freedom / points)^2
  bool reached = true;         // Choice::noise: whether some lambda leaves that noise
  int factorizations = 0;
};

// The largest weight worth trying: the fit is then a polynomial that the energy does not see.
inline constexpr double kStiffestSmoothing = 10;
// The least: it only says what the points leave open.
double softestSmoothing(const NetMatrix& data, const NetMatrix& energy);

// Solves the problem; `solver` belongs to the shape of its matrices and is left factored for the weight that is
// returned. Choosing takes some 25 factors, a given weight three. Throws InvalidInput if the weight or the noise is not
// a finite number >= 0, or if it is so small that the points do not determine all control points.
Smoothed smooth(const SmoothingProblem& problem, const Smoothing& smoothing, NetCholesky& solver);

}  // namespace strak
