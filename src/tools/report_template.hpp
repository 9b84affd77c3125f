#pragma once

namespace matchbox_slam {

/// The page as of report_page.hpp in three parts: after the first comes the address of the map's
/// picture, after the second the data as JSON in which no '<' stands.
extern const char* const kReportPageBegin;
extern const char* const kReportPageMiddle;
extern const char* const kReportPageEnd;

}  // namespace matchbox_slam
