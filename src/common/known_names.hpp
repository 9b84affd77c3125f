#pragma once

#include <string>
#include <vector>

namespace matchbox_slam {

/// The known name that was probably meant: the only one that begins so, else the nearest; empty
/// when none is near.
[[nodiscard]] std::string nearest_name(const std::string& name,
                                       const std::vector<std::string>& known);

/// That a name is not known, what was meant instead, if that is known, and which ones are:
/// "unknown parameter 'max_trys'; did you mean 'max_tries'? Known: max_tries, sigma."
/// @param kind  of name, such as "parameter"
[[nodiscard]] std::string unknown_name_text(const std::string& kind, const std::string& name,
                                            const std::vector<std::string>& meant,
                                            const std::vector<std::string>& known);

}  // namespace matchbox_slam
