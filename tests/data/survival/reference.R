# What R's survival says of data.csv and of the ratings in ../fms: r_output.csv, one number a row.
library(survival)

found <- list()
add <- function(analysis, name, values) {
  found[[length(found) + 1]] <<- data.frame(
    analysis = analysis, dataset = name, quantity = names(values),
    value = sprintf("%.13g", unname(values))
  )
}
curve <- function(fit, name, analysis) {
  s <- summary(fit, censored = TRUE)
  for (part in c("n.risk", "n.event", "surv", "std.err", "lower", "upper")) {
    values <- s[[part]]
    add(analysis, name, setNames(values, sprintf("%s at %g", part, s$time)))
  }
  q <- quantile(fit, 0.5)
  add(analysis, name, c(median = unname(q$quantile), "median lower" = unname(q$lower),
                        "median upper" = unname(q$upper)))
}
logrank <- function(test, name, analysis) {
  observed <- if (is.matrix(test$obs)) rowSums(test$obs) else test$obs
  expected <- if (is.matrix(test$exp)) rowSums(test$exp) else test$exp
  labels <- sub(".*=", "", names(test$n))
  df <- sum(expected > 0) - 1
  add(analysis, name, c(
    setNames(observed, paste("observed", labels)), setNames(expected, paste("expected", labels)),
    chi_square = test$chisq, df = df, p = pchisq(test$chisq, df, lower.tail = FALSE)
  ))
}
hazards <- function(model, name, analysis) {
  s <- summary(model)
  for (term in rownames(s$coefficients)) {
    row <- s$coefficients[term, ]
    robust <- if ("robust se" %in% names(row)) row["robust se"] else NA
    error <- if (is.na(robust)) row["se(coef)"] else robust
    beta <- row["coef"]
    values <- c(coefficient = beta, standard_error = row["se(coef)"], robust_error = robust,
                p = row["Pr(>|z|)"], low = exp(beta - qnorm(.975) * error),
                high = exp(beta + qnorm(.975) * error))
    names(values) <- paste(sub("condition", "", term), c("coefficient", "standard_error",
                                                        "robust_error", "p", "low", "high"))
    add(analysis, name, values[!is.na(values)])
  }
  add(analysis, name, c(log_likelihood = model$loglik[2],
                        likelihood_ratio = 2 * diff(model$loglik), wald = unname(model$wald.test)))
}
control <- coxph.control(eps = 1e-13, toler.chol = 1e-14, iter.max = 100)
everything <- function(set, name) {
  set$condition <- factor(set$condition)
  curve(survfit(Surv(time_s, event) ~ 1, set, conf.type = "log-log"), name, "kaplan_meier")
  if (any(duplicated(set$participant))) {
    robust <- survfit(Surv(time_s, event) ~ 1, set, cluster = participant, robust = TRUE,
                      conf.type = "log-log")
    curve(robust, name, "kaplan_meier_robust")
  }
  if (nlevels(set$condition) < 2) return(invisible())
  logrank(survdiff(Surv(time_s, event) ~ condition, set), name, "log_rank")
  if (any(duplicated(set$participant)) && name != "fms") {  # R: exactly singular
    within <- survdiff(Surv(time_s, event) ~ condition + strata(participant), set)
    logrank(within, name, "log_rank_stratified")
  }
  hazards(coxph(Surv(time_s, event) ~ condition, set, control = control), name, "cox")
  hazards(coxph(Surv(time_s, event) ~ condition, set, cluster = participant, control = control),
          name, "cox_robust")
  if ("position" %in% names(set)) {
    both <- coxph(Surv(time_s, event) ~ condition + position, set, cluster = participant,
                  control = control)
    hazards(both, name, "cox_robust_position")
  }
}

data <- read.csv("data.csv")
for (name in unique(data$dataset)) everything(data[data$dataset == name, ], name)

ratings <- read.csv("../fms/ratings.csv")
first <- do.call(rbind, lapply(split(ratings, ratings$run), function(x) {
  hit <- x$time_s[x$fms >= 10]
  data.frame(
    participant = x$participant[1], condition = x$condition[1],
    time_s = if (length(hit)) min(hit) else max(x$time_s), event = as.integer(length(hit) > 0)
  )
}))
everything(first, "fms")
everything(subset(first, condition %in% c("base", "rof_forward_whiteline")), "fms_two")

write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE, quote = FALSE)
writeLines(c(R.version.string, paste("survival", packageVersion("survival"))), "r_session.txt")
