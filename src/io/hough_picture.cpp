#include "io/hough_picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "io/map_style.hpp"

namespace matchbox_slam {
namespace {

constexpr Color kBackground{255, 255, 255};
constexpr Color kFrameColor{190, 195, 202};
constexpr Stroke kReferenceStroke{{20, 95, 215}, 2.0, 0.0};
constexpr Stroke kScanStroke{{240, 130, 20}, 2.0, 6.0};
constexpr int kWidth = 900;              ///< of a panel [pixels]
constexpr int kDomainHeight = 360;       ///< [pixels]
constexpr int kCurveHeight = 160;        ///< [pixels]
constexpr int kPanelMargin = 12;         ///< [pixels]
constexpr int kTitleHeight = 26;         ///< [pixels]
constexpr double kTitleFontSize = 18.0;  ///< [pixels]

/// A part of the picture, below its title.
struct Panel {
  int top;
  int height;
};

Panel add_panel(int& top, int height, const std::string& title, Picture& picture) {
  picture.draw_text(kPanelMargin, top + 0.4 * kTitleHeight, title, kTitleFontSize, kTextColor);
  const Panel panel{top + kTitleHeight, height};
  picture.fill(kPanelMargin - 1, panel.top - 1, kPanelMargin + kWidth + 1, panel.top + height + 1,
               kFrameColor);
  picture.fill(kPanelMargin, panel.top, kPanelMargin + kWidth, panel.top + height, kBackground);
  top = panel.top + height + kPanelMargin;
  return panel;
}

void draw_domain(const HoughPoints& points, const HoughAlignmentOptions& options, int half_cells,
                 const Panel& panel, Picture& picture) {
  const HoughGrid grid{options.angles, options.rho_cell};
  std::vector<std::vector<float>> columns;
  float strongest = 1e-9F;
  for (int k = 0; k < grid.angles; ++k) {
    columns.push_back(hough_column(points, grid.angle(k), grid.rho_cell, half_cells));
    strongest =
        std::max(strongest, *std::max_element(columns.back().begin(), columns.back().end()));
  }
  const int cells = 2 * half_cells + 1;
  for (int x = 0; x < kWidth; ++x) {
    const std::vector<float>& column = columns[static_cast<std::size_t>(x * grid.angles / kWidth)];
    for (int y = 0; y < panel.height; ++y) {
      const auto first = static_cast<std::ptrdiff_t>(y) * cells / panel.height;
      const auto last =
          std::max(first + 1, static_cast<std::ptrdiff_t>(y + 1) * cells / panel.height);
      const float votes = *std::max_element(column.begin() + first, column.begin() + last);
      // The root shows weak curves beside strong walls.
      const double ink = std::sqrt(static_cast<double>(votes / strongest));
      const auto gray = static_cast<std::uint8_t>(std::lround(255.0 * (1.0 - ink)));
      const int row = panel.top + panel.height - 1 - y;
      picture.fill(kPanelMargin + x, row, kPanelMargin + x + 1, row + 1, {gray, gray, gray});
    }
  }
}

/// @param low, high  values at the lower and the upper edge of the panel.
void draw_curve(const std::vector<float>& values, double low, double high, const Panel& panel,
                const Stroke& stroke, Picture& picture) {
  std::vector<Eigen::Vector2d> line;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x =
        kPanelMargin + (static_cast<double>(i) + 0.5) * kWidth / static_cast<double>(values.size());
    const double share = (static_cast<double>(values[i]) - low) / (high - low);
    line.emplace_back(x, panel.top + panel.height * (1.0 - std::clamp(share, 0.0, 1.0)));
  }
  picture.draw_line(line, stroke);
}

double top_of(const std::vector<float>& values) {
  return std::max(1e-9, static_cast<double>(*std::max_element(values.begin(), values.end())));
}

}  // namespace

Picture draw_hough_domains(const PointScan& reference, const PointScan& scan,
                           const HoughAlignmentOptions& options) {
  const HoughPoints reference_points = hough_points(reference.points, options.point_spacing);
  const HoughPoints scan_points = hough_points(scan.points, options.point_spacing);
  const HoughGrid grid{options.angles, options.rho_cell};
  const SpectrumKind kind =
      options.spectrum == "maximum" ? SpectrumKind::kMaximum : SpectrumKind::kEnergy;
  const std::vector<float> reference_spectrum = hough_spectrum(reference_points, grid, kind);
  const std::vector<float> scan_spectrum = hough_spectrum(scan_points, grid, kind);
  std::vector<float> correlation = correlate_spectra(reference_spectrum, scan_spectrum);
  std::rotate(correlation.begin(),
              correlation.begin() + static_cast<std::ptrdiff_t>((correlation.size() + 1) / 2),
              correlation.end());  // no rotation in the middle

  Picture picture(
      kWidth + 2 * kPanelMargin,
      2 * kDomainHeight + 2 * kCurveHeight + 4 * (kTitleHeight + kPanelMargin) + kPanelMargin,
      kBackground);
  int top = kPanelMargin;
  const int half_cells = std::max(hough_half_cells(reference_points, grid.rho_cell),
                                  hough_half_cells(scan_points, grid.rho_cell));
  draw_domain(reference_points, options, half_cells,
              add_panel(top, kDomainHeight, "Hough domain of the reference", picture), picture);
  draw_domain(scan_points, options, half_cells,
              add_panel(top, kDomainHeight, "Hough domain of the scan", picture), picture);
  const Panel spectra = add_panel(top, kCurveHeight, "spectra - the scan is dashed", picture);
  draw_curve(reference_spectrum, 0.0, top_of(reference_spectrum), spectra, kReferenceStroke,
             picture);
  draw_curve(scan_spectrum, 0.0, top_of(scan_spectrum), spectra, kScanStroke, picture);
  draw_curve(correlation, -1.0, 1.0,
             add_panel(top, kCurveHeight, "correlation from -90 to 90 degrees", picture),
             kReferenceStroke, picture);
  return picture;
}

FileContents hough_picture_file(const std::string& folder, std::size_t number,
                                const PointScan& reference, const PointScan& scan,
                                const HoughAlignmentOptions& options) {
  return {fmt::format("{}/hough_{}.png", folder, number),
          draw_hough_domains(reference, scan, options).to_png()};
}

}  // namespace matchbox_slam
