/// \file volcaustic.h
/// Everything but the OpenVDB bridge (volcaustic/openvdb.h).
#pragma once

#include "volcaustic/background.h"
#include "volcaustic/device.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"
#include "volcaustic/medium.h"
#include "volcaustic/medium_volume.h"
#include "volcaustic/mesh.h"
#include "volcaustic/options.h"
#include "volcaustic/photons.h"
#include "volcaustic/receivers.h"
#include "volcaustic/run_context.h"
#include "volcaustic/scene.h"
#include "volcaustic/session.h"
#include "volcaustic/types.h"
#include "volcaustic/vdb.h"
#include "volcaustic/view.h"
