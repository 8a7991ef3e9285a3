#pragma once
//
// The points of `strak fit`: which columns of the file mean what, and their parameters.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "strak/exchange/point_file.h"
#include "strak/fitting/least_squares.h"

namespace strak::cli {

enum class FitKind { function, surface, curve };

// The word for it on the command line.
const char* kindName(FitKind kind);

// What each column is; -1: there is none.
struct FitColumns {
  FitKind kind = FitKind::function;
  int directions = 2;
  std::vector<Index> parameters;  // none: the points get parameters of their own
  std::vector<Index> values;
  Index weight = -1;
};

// The file with the columns that --columns names ("1,3": numbers from 1); all of them where the text is empty.
PointFile pointFile(const std::filesystem::path& path, const std::string& columns);

// `kind`: the word of --kind or "" for what the columns suggest: two are a curve, three heights over a plane, and named
// u, v, x, y, z a surface. Throws InvalidInput if the columns do not fit the kind.
FitColumns fitColumns(const PointFile& file, const std::string& kind);

template <int D>
struct FitInput {
  PointPass<D> pass;  // of points that are streamed
  Index columns = 0;  // coordinates
  Index count = 0;
  std::array<double, D> from{}, to{};  // box of the parameters
  Index repeated = 0;                  // points in memory that others repeat: merged, with their weights
  bool streamed = false;               // from the file, which is too large to be kept
  // Of points in memory (not streamed).
  Net parameters, values;
  Eigen::VectorXd weights;
};

// Files larger than `keptBytes` are read block by block whenever their points are needed.
template <int D>
FitInput<D> fitInput(const PointFile& file, const FitColumns& columns, std::uintmax_t keptBytes);

}  // namespace strak::cli
