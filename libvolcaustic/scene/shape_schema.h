// What a shape may hold, as JSON Schema 2020-12.
#pragma once

#include "scene/json_document.h"

namespace volcaustic {

/// The entries of "$defs": "shape", what a node may be; one for each type, "use" and "file". They refer to each other
/// as #/$defs/NAME.
Json shapeDefinitions();
/// The section of shapes that others refer to by name.
Json shapesSectionSchema();
/// JSON Schema of the shape file. Built once.
const Json& shapeSchemaDocument();

} // namespace volcaustic
