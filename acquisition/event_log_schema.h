// SPDX-License-Identifier: Apache-2.0
// The tables of a session, as docs/data-format.md explains them; private to the event log.

#pragma once

namespace gonio {

// "gonio" in ASCII cut to 32 bits: SQLite's application_id, by which `file` and our reader know a
// session.
inline constexpr int kSessionApplicationId = 0x676f6e69;

// Angles in degrees and times in seconds on the session's clock: people read these tables. The
// exact radians stand in the events, the exact unit vectors in `samples`. @axes@ stands for
// commanded_NAME_deg and then readback_NAME_deg of each of the rig's axes.
inline constexpr const char* kSessionSchema = R"sql(
CREATE TABLE meta (
  key TEXT PRIMARY KEY NOT NULL,
  value TEXT NOT NULL
) STRICT;

CREATE TABLE events (
  seq INTEGER PRIMARY KEY,
  time_s REAL NOT NULL,
  kind TEXT NOT NULL,
  body TEXT NOT NULL CHECK (json_valid(body))
) STRICT;

CREATE TABLE poses (
  pose INTEGER PRIMARY KEY,
  candidate INTEGER NOT NULL,
  reason TEXT NOT NULL,
  score REAL,
  theta_h_deg REAL NOT NULL, theta_d_deg REAL NOT NULL, phi_d_deg REAL NOT NULL,
@axes@  move_retries INTEGER NOT NULL,
  start_s REAL NOT NULL, move_s REAL NOT NULL, end_s REAL NOT NULL,
  predicted_error REAL
) STRICT;

CREATE TABLE exposures (
  pose INTEGER NOT NULL REFERENCES poses (pose),
  frame INTEGER NOT NULL,
  exposure_s REAL NOT NULL, black_level REAL NOT NULL, monitor REAL NOT NULL,
  start_s REAL NOT NULL,
  gain_db REAL NOT NULL, temperature_c REAL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, layout TEXT NOT NULL, colour TEXT,
  saturated_red INTEGER NOT NULL, saturated_green INTEGER NOT NULL,
  saturated_blue INTEGER NOT NULL,
  counts BLOB NOT NULL,
  PRIMARY KEY (pose, frame)
) STRICT;

CREATE TABLE samples (
  pose INTEGER NOT NULL REFERENCES poses (pose),
  part INTEGER NOT NULL,
  theta_i_deg REAL NOT NULL, phi_i_deg REAL NOT NULL,
  theta_o_deg REAL NOT NULL, phi_o_deg REAL NOT NULL,
  theta_h_deg REAL NOT NULL, theta_d_deg REAL NOT NULL, phi_d_deg REAL NOT NULL,
  wi_x REAL NOT NULL, wi_y REAL NOT NULL, wi_z REAL NOT NULL,
  wo_x REAL NOT NULL, wo_y REAL NOT NULL, wo_z REAL NOT NULL,
  f_r_red REAL NOT NULL, f_r_green REAL NOT NULL, f_r_blue REAL NOT NULL,
  sigma_red REAL, sigma_green REAL, sigma_blue REAL,
  sigma_systematic_red REAL, sigma_systematic_green REAL, sigma_systematic_blue REAL,
  PRIMARY KEY (pose, part)
) STRICT;

CREATE VIEW measurements AS
  SELECT p.pose, s.part, p.reason, p.end_s AS time_s, s.theta_h_deg, s.theta_d_deg, s.phi_d_deg,
         s.theta_i_deg, s.theta_o_deg, s.f_r_red, s.f_r_green, s.f_r_blue,
         s.sigma_red, s.sigma_green, s.sigma_blue,
         s.sigma_systematic_red, s.sigma_systematic_green, s.sigma_systematic_blue,
         (SELECT count(*) FROM exposures e WHERE e.pose = p.pose) AS frames, p.predicted_error
  FROM poses p JOIN samples s USING (pose) ORDER BY p.pose, s.part;
)sql";

// A table and the condition under which a new row would replace an old one (INSERT OR REPLACE
// deletes without firing DELETE triggers).
struct SessionTable {
  const char* name;
  const char* same_key;
};
inline constexpr SessionTable kSessionTables[] = {
    {"meta", "key = NEW.key"},
    {"events", "seq = NEW.seq"},
    {"poses", "pose = NEW.pose"},
    {"exposures", "pose = NEW.pose AND frame = NEW.frame"},
    {"samples", "pose = NEW.pose AND part = NEW.part"},
};

}  // namespace gonio
