// SPDX-License-Identifier: Apache-2.0
// Opens what a command line names: reflectance of any kind, priors, the fit of a session.

#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "acquisition/session_record.h"
#include "brdf/brdf.h"
#include "fitting/fit.h"
#include "fitting/lobe_model.h"
#include "fitting/prior.h"

namespace gonio {

// A MERL .binary, a material .yaml, a fit .yaml (it has a `format` key) or a session directory
// (EstimateOfSession()). Throws ConfigError "PATH: ...".
std::unique_ptr<Brdf> OpenAny(const std::filesystem::path& path);

// The fitted model in a fit file, or of a session (its fit). Throws ConfigError "PATH: ...", also
// if it is neither.
std::unique_ptr<LobeModel> OpenFit(const std::filesystem::path& path);

// Whether a YAML file says that it is a fit. False for anything else, unreadable files included.
bool IsFitFile(const std::filesystem::path& path);

// DIR/fit.yaml if the session got that far; else its samples are fitted now, as `gonio run` would
// have. Throws ConfigError if there are none.
inline constexpr const char* kFitFile = "fit.yaml";
DsbrdfFit FitOfSession(const std::filesystem::path& dir);

// The best a session's samples say: of its process where it was run with a learned prior, else its
// fit. Throws ConfigError if there are none.
std::unique_ptr<Brdf> EstimateOfSession(const std::filesystem::path& dir);

// The prior the session was run with. Throws ConfigError if it has changed or moved since.
Prior PriorOfSession(const SessionInfo& info);

// SHA-256 of a prior's numbers, to ten digits: the same on every machine.
std::string HashOf(const Prior& prior);

}  // namespace gonio
