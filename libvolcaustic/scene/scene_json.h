// A scene as a JSON document, and the document that describes all of them.
#pragma once

#include "scene/json_document.h"
#include "volcaustic/scene.h"

namespace volcaustic {

Json sceneDocument(const Scene& scene);
/// JSON Schema 2020-12 of the scene file. Built once.
const Json& sceneSchemaDocument();

} // namespace volcaustic
