"""From runs to continuous correction masses: influence coefficients, their covariance, diagnosis."""
