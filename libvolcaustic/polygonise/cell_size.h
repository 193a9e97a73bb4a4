// Which size of cells does what is asked for.
#pragma once

#include "polygonise/run.h"

namespace volcaustic {

/// Polygonises with the largest cells that fulfil the options, as often as it takes to know them.
PolygoniseResult polygoniseAsAsked(PolygoniseJob& job, const PolygoniseOptions& options);

} // namespace volcaustic
