# What R says about data.csv beside it (written here first: wine of the package ordinal, and made-up answers):
# writes data.csv, r_output.csv and r_session.txt. Run once, in this folder: Rscript reference.R
# Debian: r-base-core r-cran-ordinal r-cran-mass
suppressPackageStartupMessages({
  library(ordinal)
  library(MASS)
})
options(warn = 1)

found <- list()
add <- function(analysis, dataset, values) {
  stopifnot(!is.null(names(values)), all(nzchar(names(values))))
  text <- ifelse(is.finite(values), sprintf("%.17g", values), "")
  found[[length(found) + 1]] <<- data.frame(
    analysis = analysis, dataset = dataset, quantity = names(values), value = text
  )
}

# --- data ---------------------------------------------------------------------------------------
wines <- data.frame(dataset = "wine", who = as.character(wine$judge), answer = as.integer(wine$rating),
                    a = as.character(wine$temp), b = as.character(wine$contact))
set.seed(14)
answers <- function(name, people, each, effect, sd, cuts) {
  who <- rep(seq_len(people), each = each)
  a <- rep(c("on", "off", "part"), length.out = people * each)
  b <- ifelse(runif(people * each) < .5, "hall", "garden")
  eta <- effect * (a == "on") + 0.4 * (b == "hall") + rnorm(people, sd = sd)[who]
  answer <- findInterval(eta + rlogis(people * each), cuts)
  data.frame(dataset = name, who = as.character(who), answer = answer, a = a, b = b)
}
data <- rbind(
  wines,
  answers("repeated", 25, 6, 1.2, 1.5, c(-1, 0.7, 2.2)),
  answers("few", 9, 4, 0.8, 0.8, c(0, 1.5)),
  answers("independent", 80, 1, 1, 0, c(-1, 0.5, 1.8))
)
write.csv(data, "data.csv", row.names = FALSE, quote = FALSE)
data <- read.csv("data.csv")

# --- fits ---------------------------------------------------------------------------------------
of <- function(name) {
  one <- data[data$dataset == name, ]
  one$y <- factor(one$answer, ordered = TRUE)
  one$a <- relevel(factor(one$a), ref = if (name == "wine") "cold" else "off")
  one$b <- factor(one$b)
  one$who <- factor(one$who)
  one
}
# The likelihood itself, by base R's integrate(), at its maximum by Newton's method: clmm stops up to
# 4e-5 short of it (the gradient of its likelihood is some 1e-5 there).
maximum <- function(one, start) {
  x <- model.matrix(~ a + b, one)[, -1]
  y <- as.integer(one$y)
  cuts <- nlevels(one$y) - 1
  people <- split(seq_along(y), one$who)
  loss <- function(p) {
    ends <- c(-Inf, p[seq_len(cuts)], Inf)
    eta <- x %*% p[cuts + seq_len(ncol(x))]
    sd <- p[length(p)]
    -sum(sapply(people, function(i) log(integrate(function(z) {
      shift <- outer(c(eta[i]), sd * z, "+")
      shares <- plogis(ends[y[i] + 1] - shift) - plogis(ends[y[i]] - shift)
      exp(colSums(log(shares))) * dnorm(z)
    }, -8, 8, rel.tol = 1e-13, subdivisions = 1000)$value)))
  }
  h <- 1e-3
  unit <- function(k) replace(numeric(length(start)), k, h)
  slope <- function(p) sapply(seq_along(p), function(k) {
    e <- unit(k)
    (8 * (loss(p + e) - loss(p - e)) - (loss(p + 2 * e) - loss(p - 2 * e))) / (12 * h)
  })
  bend <- function(p) sapply(seq_along(p), function(k) {
    e <- unit(k)
    (8 * (slope(p + e) - slope(p - e)) - (slope(p + 2 * e) - slope(p - 2 * e))) / (12 * h)
  })
  p <- start
  for (i in 1:2) p <- p - solve(bend(p), slope(p))
  list(estimate = p, se = sqrt(diag(solve(bend(p)))), log_likelihood = -loss(p))
}
summed <- function(fit) {
  table <- coef(summary(fit))
  values <- c(table[, 1:4])
  names(values) <- c(outer(rownames(table), c("estimate", "se", "z", "p"), paste))
  c(values, log_likelihood = as.numeric(logLik(fit)))
}
for (name in c("wine", "repeated", "few")) {
  one <- of(name)
  # Adaptive Gauss-Hermite quadrature, as many nodes as ours.
  fit <- function(formula) suppressWarnings(clmm(
    formula, one, nAGQ = 25, control = clmm.control(grtol = 1e-10, gradTol = 1e-7)))
  full <- fit(y ~ a + b + (1 | who))
  add("clmm", name, c(summed(full), sd = as.numeric(attr(VarCorr(full)$who, "stddev"))))
  sd <- as.numeric(attr(VarCorr(full)$who, "stddev"))
  exact <- maximum(one, c(coef(full), sd))
  labels <- c(names(coef(full)), "sd")
  values <- c(exact$estimate, exact$se, exact$log_likelihood)
  names(values) <- c(paste(labels, "estimate"), paste(labels, "se"), "log_likelihood")
  add("integrate", name, values)
  add("clmm", name, c(
    lr_a = 2 * as.numeric(logLik(full) - logLik(fit(y ~ b + (1 | who)))),
    lr_b = 2 * as.numeric(logLik(full) - logLik(fit(y ~ a + (1 | who))))))
}
for (name in c("wine", "repeated", "independent")) {
  one <- of(name)
  full <- clm(y ~ a + b, data = one, control = clm.control(gradTol = 1e-12))
  add("clm", name, summed(full))
  if (name != "wine") { # in wine some answers were not given under every level
    loose <- clm(y ~ b, nominal = ~a, data = one, control = clm.control(gradTol = 1e-10))
    chi <- 2 * as.numeric(logLik(loose) - logLik(full))
    df <- (nlevels(one$y) - 2) * 2
    add("clm", name, c(nominal_lr_a = chi, nominal_df_a = df,
                       nominal_p_a = pchisq(chi, df, lower.tail = FALSE)))
  }
}
one <- of("independent")
full <- polr(y ~ a + b, one, Hess = TRUE, control = list(reltol = 1e-16, maxit = 1000))
add("polr", "independent", c(coef(full), full$zeta, log_likelihood = as.numeric(logLik(full))))

write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE)
writeLines(capture.output(sessionInfo()), "r_session.txt")
