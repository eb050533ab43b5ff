// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_pictures.h"
namespace gonio {
void WriteStudyPictures(const StudyConfig&, const std::vector<std::filesystem::path>&,
                        const StudyResult&, const std::filesystem::path&) {}
}  // namespace gonio
