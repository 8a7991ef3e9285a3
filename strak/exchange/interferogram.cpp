#include "strak/exchange/interferogram.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "strak/base/error.h"
#include "strak/exchange/binary_number.h"

namespace strak {

namespace {

// Places in the header; all numbers big-endian.
constexpr std::size_t kHeaderSize = 6, kIntensityBytes = 60, kWidth = 68, kHeight = 70, kPhaseBytes = 72, kScale = 164,
                      kWavelength = 168, kObliquity = 176, kLateral = 184, kResolution = 218, kLeastHeader = 834;
constexpr std::int32_t kInvalid = 2147483640;  // and above
constexpr double kMillimetres = 1000;          // to the metre

// Steps of the phase to a wave, by the code for it; zero for an unknown one.
double stepsPerWave(std::int16_t code) {
  switch (code) {
    case 0:
      return 4096;
    case 1:
      return 32768;
    case 2:
      return 131072;
    default:
      return 0;
  }
}

}  // namespace

bool isInterferogram(std::string_view head) {
  return head.size() > 3 && head.starts_with("\x88\x1b\x03") && head[3] >= '\x6f' && head[3] <= '\x71';
}

Net interferogramHeights(std::string_view bytes) {
  if (bytes.size() < kLeastHeader) throw InvalidInput("the interferogram ends within its header: it may be damaged");
  const std::int64_t header = binaryNumber<std::int32_t>(bytes, kHeaderSize, true),
                     intensities = binaryNumber<std::int32_t>(bytes, kIntensityBytes, true),
                     phases = binaryNumber<std::int32_t>(bytes, kPhaseBytes, true);
  const Index width = binaryNumber<std::uint16_t>(bytes, kWidth, true),
              height = binaryNumber<std::uint16_t>(bytes, kHeight, true);
  if (width < 1 || height < 1) throw InvalidInput("the interferogram holds no phases: save it with its phase data");
  if (header < static_cast<std::int64_t>(kLeastHeader) || intensities < 0 || phases != 4 * width * height ||
      header + intensities + phases > static_cast<std::int64_t>(bytes.size())) {
    throw InvalidInput(
        fmt::format("the interferogram does not hold the {} x {} phases that its header announces: it may be damaged",
                    width, height));
  }
  const double scale = binaryNumber<float>(bytes, kScale, true), wave = binaryNumber<float>(bytes, kWavelength, true),
               obliquity = binaryNumber<float>(bytes, kObliquity, true),
               lateral = binaryNumber<float>(bytes, kLateral, true),
               steps = stepsPerWave(binaryNumber<std::int16_t>(bytes, kResolution, true));
  const double perStep = kMillimetres * scale * obliquity * wave / steps;
  if (!(steps > 0) || !std::isfinite(perStep) || perStep == 0 || !(lateral >= 0) || !std::isfinite(lateral)) {
    throw InvalidInput("the interferogram's header does not say how high a phase is: it may be damaged");
  }
  const double step = lateral > 0 ? kMillimetres * lateral : 1;
  Net points(width * height, 3);
  Index count = 0;
  std::size_t at = static_cast<std::size_t>(header + intensities);
  for (Index row = height - 1; row >= 0; --row) {
    for (Index column = 0; column < width; ++column, at += 4) {
      const auto phase = binaryNumber<std::int32_t>(bytes, at, true);
      if (phase >= kInvalid) continue;
      points.row(count++) << step * static_cast<double>(column), step * static_cast<double>(row), perStep * phase;
    }
  }
  if (count == 0) throw InvalidInput("all samples of the interferogram are marked as invalid");
  points.conservativeResize(count, Eigen::NoChange);
  return points;
}

}  // namespace strak
