#include "strak/report/page.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "strak/report/svg.h"

namespace strak {

// The files of strak/report/web, embedded by the build.
extern const std::string_view kPageHtml, kPageCss, kViewerHtml, kModelJs, kPainterJs, kViewerJs;

std::string htmlPage(std::string_view title, std::string_view body, std::string_view sceneJson) {
  const std::string name = escaped(title);
  const std::string script = fmt::format("{}{}{}", kModelJs, kPainterJs, kViewerJs);
  const std::vector<std::pair<std::string_view, std::string_view>> parts{{"{{title}}", name},
                                                                         {"{{style}}", kPageCss},
                                                                         {"{{body}}", body},
                                                                         {"{{data}}", sceneJson},
                                                                         {"{{script}}", script}};
  std::string out;
  std::string_view rest = kPageHtml;
  // One pass, so that nothing inside a part is taken for a mark.
  while (!rest.empty()) {
    std::size_t at = rest.size();
    std::pair<std::string_view, std::string_view> next;
    for (const auto& part : parts) {
      const std::size_t found = rest.find(part.first);
      if (found >= at) continue;
      at = found;
      next = part;
    }
    out += rest.substr(0, at);
    out += next.second;
    rest.remove_prefix(at + next.first.size());
  }
  return out;
}

std::string_view viewerMarkup() { return kViewerHtml; }

std::string htmlFigure(std::string_view svg, std::string_view captionHtml) {
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", svg, captionHtml);
}

}  // namespace strak
