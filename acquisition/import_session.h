// SPDX-License-Identifier: Apache-2.0
// Samples that some other instrument measured, as a session like our own.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/event_log.h"
#include "brdf/samples_csv.h"

namespace gonio {

inline constexpr const char* kImportedFolder = "imported";  // in the session: the file itself

// A file of samples and what is known of it.
struct ImportedFile {
  std::filesystem::path path;
  std::string bytes;
  std::string format;                   // "csv", "rt300s", "cornell"
  std::string quantity;                 // how f_r came out of the file's values, in words
  std::string channels;                 // which of the file's values the three channels are
  std::string bands_nm;                 // how they were asked for, of cornell; empty: as a rule
  std::string title;                    // of the sample, if the file tells
  std::string started;                  // by the instrument's clock, if the file tells
  std::vector<MeasuredSample> samples;  // not empty
};

// Makes DIR with the log of a session that measured these samples and ended, and with a copy of the
// file in DIR/imported/. Samples in a row with the same pose number become the parts of one pose;
// poses are numbered 1, 2, ... anew. A pose has no raw frames; its arms stand where the samples'
// directions are.
//
// `info`: rig and plan as the caller wishes to have them; `imported` is filled in. Throws
// ConfigError "DIR: exists already; ..." or std::runtime_error "...: cannot write: ..."; nothing is
// left behind then.
void WriteImportedSession(const std::filesystem::path& dir, SessionInfo info,
                          const ImportedFile& file);

// Makes channels unusable, by an infinite sigma, of samples whose light and detector are nearer to
// each other than this [rad]: one arm is in the other's light. Returns how many samples those are.
int MarkShadowed(double min_separation, std::vector<MeasuredSample>* samples);

}  // namespace gonio
