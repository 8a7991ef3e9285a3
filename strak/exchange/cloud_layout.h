#pragma once
//
// How the points lie in a point cloud file (PLY, PCD, LAS): what its header says.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// One number of a point.
struct CloudField {
  enum class Type { signedInteger, unsignedInteger, real };
  std::string name;
  Type type = Type::real;
  int bytes = 4;
  std::size_t offset = 0;  // in the point's record
  std::size_t group = 0;   // offset and bytes of the field that this is an element of
  std::size_t groupBytes = 4;
  double factor = 1, shift = 0;  // the number is shift + factor * what stands there
};

struct CloudLayout {
  std::vector<CloudField> fields;
  bool binary = false, bigEndian = false;
  bool compressed = false;  // binary, by LZF and field by field (PCD)
  Index count = 0;
  std::size_t record = 0;     // bytes a point, if binary
  std::size_t headBytes = 0;  // where the points begin
  Index headLines = 0;
};

// Reads the header at the beginning of `head`; nothing if it is none of a PLY, PCD or LAS file. Throws InvalidInput,
// without the file's name, if the header is damaged or announces what is not supported (points that are not the first
// element).
std::optional<CloudLayout> cloudLayout(std::string_view head);

// The type and bytes of a number that a PLY header calls `name`; false for other words.
bool plyType(std::string_view name, CloudField& field);

// The number of `field` in a point's record.
double cloudNumber(const CloudField& field, const char* record, bool bigEndian);

// The numbers of all fields of `rows` records, row by row: as many as the layout has fields. Cost: about 1 ns a number
// for the usual floats and doubles.
void cloudNumbers(const CloudLayout& layout, const char* records, Index rows, double* numbers);

}  // namespace strak
