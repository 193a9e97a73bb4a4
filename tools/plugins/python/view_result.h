#pragma once

#include "call.h"
#include "handles.h"

#include <volcaustic/view.h>

namespace volcaustic::python {

/// Hands a copy of the picture to a callable after each pass; empty for None. \throws TypeError
ViewObserver observerOf(Call& call, const py::object& onPass);

} // namespace volcaustic::python
