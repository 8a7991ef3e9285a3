#pragma once
//
// Self-contained HTML pages around the viewer.

#include <string>
#include <string_view>

namespace strak {

// A whole document: `title` is escaped here, `body` is HTML, `sceneJson` the data of the viewer (viewerData).
// Everything the page needs is inside; a content security policy forbids it to load anything.
std::string htmlPage(std::string_view title, std::string_view body, std::string_view sceneJson);

// The markup of the viewer, to be put into a body once.
std::string_view viewerMarkup();

// A drawing with a caption (HTML).
std::string htmlFigure(std::string_view svg, std::string_view captionHtml);

}  // namespace strak
