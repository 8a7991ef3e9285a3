#include "apps/cli/json.h"

#include <fmt/format.h>

namespace strak::cli {

Json jsonHead(const std::string& command, const std::vector<std::string>& inputs) {
  return Json{{"version", STRAK_VERSION}, {"command", command}, {"inputs", inputs}};
}

Json jsonOf(const Audit& audit) {
  return Json{{"valid", audit.valid},
              {"invalid_faces", audit.invalidFaces},
              {"edges", audit.edges.size()},
              {"largest_gap", audit.largestGap},
              {"largest_tolerance", audit.largestTolerance}};
}

void printJson(const Json& json) { fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace)); }

}  // namespace strak::cli
