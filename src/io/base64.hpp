#pragma once

#include <string>

namespace matchbox_slam {

/// Bytes as text of letters, digits, '+' and '/', padded with '=' (RFC 4648, section 4).
[[nodiscard]] std::string base64(const std::string& bytes);

}  // namespace matchbox_slam
