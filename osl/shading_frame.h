/* The frame in which directions are given: z is the shading normal. The viewer's direction wo has azimuth 0 or, for an
 * anisotropic fit, x and y are the principal axes of the surface. */

#if ANISOTROPIC
#  define TANGENT_PARAMETERS , vector Tangent, vector MeshTangent, float Rotation
#  define TANGENT_ARGUMENTS , Tangent, MeshTangent, Rotation
#else
#  define TANGENT_PARAMETERS
#  define TANGENT_ARGUMENTS
#endif

struct ShadingFrame {
  vector x;
  vector y;
  vector z;
  vector wo;     /* in the frame itself */
};

vector to_local(ShadingFrame frame, vector w)
{
  return vector(dot(w, frame.x), dot(w, frame.y), dot(w, frame.z));
}

vector to_world(ShadingFrame frame, vector w)
{
  return w[0] * frame.x + w[1] * frame.y + w[2] * frame.z;
}

/* Any direction perpendicular to an axis. */
vector perpendicular(vector axis)
{
  return normalize(cross(axis, fabs(axis[2]) < NEARLY_PARALLEL ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)));
}

/* The frame at a point. Interpolation or a bump map may have turned the normal away from the viewer; such a normal is
 * turned back until the viewer just sees its surface. */
ShadingFrame shading_frame(normal shading_normal, normal surface_normal, vector to_viewer TANGENT_PARAMETERS)
{
  ShadingFrame frame;
  frame.z = length(shading_normal) > LEAST_NORMAL ? normalize(shading_normal) : surface_normal;
  float facing = dot(frame.z, to_viewer);
  if (facing < LEAST_FACING) {
    frame.z = normalize(frame.z + (LEAST_FACING - facing) * to_viewer);
  }
#if ANISOTROPIC
  vector given = length(Tangent) > LEAST_TANGENT ? Tangent : MeshTangent;
  vector tangent = given - dot(given, frame.z) * frame.z;
#else
  vector tangent = to_viewer - dot(to_viewer, frame.z) * frame.z;
#endif
  if (length(tangent) < LEAST_TANGENT) {
    tangent = perpendicular(frame.z);
  }
  /* of a short tangent rounding leaves a part along the normal */
  frame.y = normalize(cross(frame.z, tangent));
  frame.x = cross(frame.y, frame.z);
#if ANISOTROPIC
  float azimuth = M_2PI * Rotation + PRINCIPAL_AZIMUTH;
  frame.x = cos(azimuth) * frame.x + sin(azimuth) * frame.y;
  frame.y = cross(frame.z, frame.x);
  frame.wo = to_local(frame, to_viewer);
#else
  float cosine = dot(to_viewer, frame.z);
  frame.wo = vector(sqrt(1.0 - cosine * cosine), 0.0, cosine);
#endif
  return frame;
}

/* A direction in the frame of the fit, whose x is the tangent. */
#if ANISOTROPIC
vector to_fit(vector w)
{
  return vector(cos(PRINCIPAL_AZIMUTH) * w[0] - sin(PRINCIPAL_AZIMUTH) * w[1],
                sin(PRINCIPAL_AZIMUTH) * w[0] + cos(PRINCIPAL_AZIMUTH) * w[1], w[2]);
}
#else
#  define to_fit(w) w
#endif
