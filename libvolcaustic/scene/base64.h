// Base64 (RFC 4648), as data URIs hold it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace volcaustic {

/// Bytes that `text` decodes to when it is base64.
std::uint64_t base64Size(std::string_view text);
/// Ends at the first character that is not of the alphabet, and so is shorter than base64Size() for other text.
std::string decodeBase64(std::string_view text);

} // namespace volcaustic
