// JSON text to and from nlohmann's ordered document, with what the library alone does not give: duplicate keys are
// errors, and every error carries its place.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace volcaustic {

using Json = nlohmann::ordered_json;

/// Parses JSON with // and /* */ comments.
/// \throws Error(Input) "name:line:column: ..." for bad syntax, "name:/pointer: ..." for a key given twice or for
/// nesting beyond 64 levels, or more than four million values.
Json parseJson(std::string_view text, const std::string& name);

/// A key as a token of a JSON pointer (RFC 6901): ~ and / escaped.
std::string pointerToken(std::string_view key);
/// The keys of a JSON pointer that starts with '/'.
std::vector<std::string> pointerKeys(std::string_view pointer);

/// A value for a message: its JSON, cut to a readable length.
std::string excerpt(const Json& value);

/// Indented text with arrays of scalars on one line. With a schema, a comment from its descriptions stands above each
/// key.
std::string prettyText(const Json& value, const Json* schema = nullptr);

} // namespace volcaustic
